#include "sim/footprint.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

namespace taut {
namespace {

/// Of a method, by what it takes for each particle beside the world: bytes, and s of a step. Both
/// were measured on ropes of 20,000 particles, in a single span.
struct Cost {
  std::string_view method;
  double memory, step;
  bool eliminates = false;  // by TensionSystem, which has columns for links that meet in a body
};

constexpr Cost kCosts[] = {
    {"impulse", 100, 2e-8}, {"dynamic-constraints", 700, 2e-7, true},
    {"sdfast", 8000, 2e-6}, {"multibody", 8000, 2e-5},
    {"springs", 350, 1e-8}, {"xpbd", 250, 3e-8},
    {"direct", 1000, 2e-7}, {"truth", 1500, 1e-6, true},
};

/// Ends and pins that meet others in a free body.
double meeting(const World& world) {
  std::vector<std::size_t> holds(world.bodies.size());
  for (const Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) {
      if (!is_prescribed(world, hold.to)) ++holds[hold.to.body];
    }
  }
  double sum = 0;
  for (const std::size_t count : holds) sum += count > 1 ? double(count) : 0;
  return sum;
}

/// The dense system of n links: the matrix, its decomposition, and what Eigen packs of them, in
/// bytes by n^2; a third of n^3 additions and multiplications for each of a step's four solves.
constexpr double kDenseMemory = 18, kDenseStep = 1.6e-10;

bool is_dense(const Settings& settings) {
  const auto solver = settings.find("solver");
  if (solver == settings.end()) return false;
  const auto* name = std::get_if<std::string>(&solver->second);
  return name && *name == "dense";
}

}  // namespace

Footprint footprint(const MethodInfo& method, const World& world, const Settings& settings) {
  double particles = 0, links = 0, memory = 0;
  for (const Connector& connector : world.connectors) {
    particles += double(connector.particles());
    links += double(connector.links());
    memory += double(sizeof(Connector) + connector.holds.size() * sizeof(Hold));
  }
  // A particle's position, velocity, mass and link, and once more its position in what is shown.
  constexpr double kParticle = 3 * sizeof(Vec3) + 2 * sizeof(double);
  memory += double(world.bodies.size() * sizeof(Body)) + particles * kParticle;
  const auto listed = std::ranges::find(kCosts, method.name, &Cost::method);
  const Cost cost =
      listed != std::end(kCosts) ? *listed : *std::ranges::max_element(kCosts, {}, &Cost::memory);
  // A body weighs as much as a few particles.
  const double all = particles + 4 * double(world.bodies.size());
  Footprint sum{2 * memory + all * cost.memory, all * cost.step};
  if (cost.eliminates) {
    const double columns = meeting(world);
    sum.memory += sizeof(double) * columns * (links + 2 * columns);
  }
  if (is_dense(settings)) {
    sum.memory += kDenseMemory * links * links;
    sum.step += kDenseStep * links * links * links;
  }
  return sum;
}

}  // namespace taut
