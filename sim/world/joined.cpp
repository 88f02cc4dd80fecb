#include "sim/world/joined.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "sim/world/places.h"

namespace taut {
namespace {

// Two links between joined particles would lie on each other, one would have no length.
constexpr std::size_t kShortestLoop = 3;

bool is_held(const World& world, const Joint::Particle& at) {
  return holds(world.connectors[at.connector], at.particle);
}

}  // namespace

std::string joint_flaw(const World& world) {
  std::set<std::pair<std::size_t, std::size_t>> known;
  for (const Joint& joint : world.joints) {
    if (joint.particles.size() < 2) return "a joint has less than two particles";
    std::size_t held = 0;
    for (const Joint::Particle& at : joint.particles) {
      if (at.connector >= world.connectors.size() ||
          at.particle >= world.connectors[at.connector].particles()) {
        return "a joint names a particle that does not exist";
      }
      const Connector& connector = world.connectors[at.connector];
      if (connector.model != ConnectorModel::links) {
        return connector.name + " is a massless span, which nothing can be joined to";
      }
      if (!known.emplace(at.connector, at.particle).second) {
        return "a particle of " + connector.name + " is in two joints";
      }
      held += is_held(world, at) ? 1 : 0;
    }
    if (held > 1) return "two particles of a joint are held";
    for (const Joint::Particle& a : joint.particles) {
      for (const Joint::Particle& b : joint.particles) {
        if (a.connector == b.connector && a.particle < b.particle &&
            b.particle - a.particle < kShortestLoop) {
          return world.connectors[a.connector].name +
                 " is joined to itself with less than three links between";
        }
      }
    }
  }
  return {};
}

const Joint::Particle& leader(const World& world, const Joint& joint) {
  const auto held = std::ranges::find_if(
      joint.particles, [&](const Joint::Particle& at) { return is_held(world, at); });
  return held == joint.particles.end() ? joint.particles.front() : *held;
}

const Joint* find_joint(const World& world, std::size_t connector, std::size_t particle) {
  for (const Joint& joint : world.joints) {
    for (const Joint::Particle& at : joint.particles) {
      if (at.connector == connector && at.particle == particle) return &joint;
    }
  }
  return nullptr;
}

double joined_mass(const World& world, std::size_t connector, std::size_t particle) {
  const Joint* joint = find_joint(world, connector, particle);
  return joint ? joined_mass(world, *joint) : world.connectors[connector].particle_mass[particle];
}

double joined_mass(const World& world, const Joint& joint) {
  double mass = 0;
  for (const Joint::Particle& at : joint.particles) {
    mass += world.connectors[at.connector].particle_mass[at.particle];
  }
  return mass;
}

void find_leaders(const World& world, std::vector<std::uint32_t>& leaders) {
  std::vector<std::size_t> first{0};
  for (const Connector& connector : world.connectors) {
    first.push_back(first.back() + connector.particles());
  }
  leaders.resize(first.back());
  std::iota(leaders.begin(), leaders.end(), 0u);
  const auto point = [&](const Joint::Particle& at) { return first[at.connector] + at.particle; };
  for (const Joint& joint : world.joints) {
    const auto leads = static_cast<std::uint32_t>(point(leader(world, joint)));
    for (const Joint::Particle& at : joint.particles) leaders[point(at)] = leads;
  }
}

void place_joined(World& world) {
  for (const Joint& joint : world.joints) place_joined(world, joint);
}

void place_joined(World& world, const Joint& joint) {
  const Joint::Particle& leads = leader(world, joint);
  const Connector& from = world.connectors[leads.connector];
  for (const Joint::Particle& at : joint.particles) {
    if (&at == &leads) continue;
    Connector& to = world.connectors[at.connector];
    to.position[at.particle] = from.position[leads.particle];
    to.velocity[at.particle] = from.velocity[leads.particle];
  }
}

}  // namespace taut
