#include "sim/run/footprint.h"

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

constexpr double kDense = 18;      // bytes, by the square of links: matrix, decomposition, packing
constexpr double kContact = 2600;  // bytes, of a particle at obstacles, by `direct`
constexpr double kJoint = 2000;  // bytes, of a joint that is eliminated, in nets rather than trees

bool is_dense(const Settings& settings) {
  const auto solver = settings.find("solver");
  if (solver == settings.end()) return false;
  const auto* name = std::get_if<std::string>(&solver->second);
  return name && *name == "dense";
}

}  // namespace

double memory_of(const MethodInfo& method, const World& world, const Settings& settings) {
  double particles = 0, links = 0, memory = 0;
  for (const Connector& connector : world.connectors) {
    particles += double(connector.particles());
    links += double(connector.links());
    memory += double(sizeof(Connector) + connector.holds.size() * sizeof(Hold));
  }
  // A particle's position, velocity, mass and link, and once more its position in what is shown.
  constexpr double kParticle = 3 * sizeof(Vec3) + 2 * sizeof(double);
  memory += double(world.bodies.size() * sizeof(Body)) + particles * kParticle;
  // A body takes the memory of some particles: measured on 100,000 in flight.
  const auto bodies = double(world.bodies.size());
  double sum = 2 * memory + (particles + 12 * bodies) * method.particle_memory;
  if (has_contact(world) || has_strings(world)) sum += kContact * particles;
  sum += kJoint * double(world.joints.size());
  if (method.eliminates) {
    const double columns = meeting(world);
    sum += sizeof(double) * columns * (links + 2 * columns);
  }
  if (is_dense(settings)) sum += kDense * links * links;
  return sum;
}

}  // namespace taut
