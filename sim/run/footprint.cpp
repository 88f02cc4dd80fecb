#include "sim/run/footprint.h"

#include <cmath>
#include <vector>

namespace taut {
namespace {

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

/// Of a particle at obstacles, by `direct`: measured on a rope of 20,001 on a floor that is shown
/// within steps.
constexpr double kContactMemory = 2600, kContactStep = 6e-7;  // bytes, s

/// The elimination of n joints, of nets rather than trees: memory by n, twelve solves of n^1.5.
constexpr double kJointMemory = 2000, kJointStep = 1.5e-7;  // bytes, s

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
  // A body takes the memory of some particles and the time of a few: measured on 100,000 in flight.
  const auto bodies = double(world.bodies.size());
  Footprint sum{2 * memory + (particles + 12 * bodies) * method.cost.memory,
                (particles + 4 * bodies) * method.cost.step};
  if (has_contact(world) || has_strings(world)) {
    sum.memory += kContactMemory * particles;
    sum.step += kContactStep * particles;
  }
  const auto joints = double(world.joints.size());
  sum.memory += kJointMemory * joints;
  sum.step += kJointStep * joints * std::sqrt(joints);
  if (method.cost.eliminates) {
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
