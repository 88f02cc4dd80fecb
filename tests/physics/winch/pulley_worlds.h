// Two ropes that hang from one pulley, for tests of those.
#pragma once

#include <algorithm>

#include "../worlds.h"
#include "sim/world/connector.h"
#include "sim/world/winched.h"

namespace taut::pulley_worlds {

/// Ropes of `links` links that hang from the origin at angles (degrees from down) with point masses
/// (kg) at their ends; rope passes from the first to the second.
struct Machine {
  double left = 0.8, right = 1.2;  // m
  double left_mass = 1, right_mass = 1;
  double degrees = 0;  // of the right one
  double density = 0;  // kg/m
  double friction = 0, bearing = 0, inertia = 0;
  std::size_t links = 1;
};

inline World atwood(const Machine& machine) {
  World world;
  const auto rope = [&](const char* name, double length, const Vec3& towards) {
    return straight_connector(name, length, machine.density * length, machine.links + 1,
                              Vec3::Zero(), towards);
  };
  Connector left = rope("left", machine.left, worlds::from_down(0));
  std::ranges::reverse(left.position);
  Connector right = rope("right", machine.right, worlds::from_down(machine.degrees));
  left.holds = {{machine.links, worlds::fixed_at(Vec3::Zero())}};
  right.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  left.particle_mass.front() += machine.left_mass;
  right.particle_mass.back() += machine.right_mass;
  world.connectors = {left, right};
  add_pulley(world, "eye", 0, 1, machine.inertia);
  world.pulleys[0].friction = machine.friction;
  world.pulleys[0].bearing = machine.bearing;
  finish(world);
  return world;
}

/// Lets rope that hangs straight down pass at `speed` (m/s).
inline void set_passing(World& world, double speed) {
  world.pulleys[0].speed = speed;
  for (Connector& rope : world.connectors) {
    const double sign = rope.name == "left" ? 1 : -1;
    for (std::size_t i = 0; i < rope.particles(); ++i) {
      rope.velocity[i].y() = sign * speed * -rope.position[i].y() / rope.length;
    }
  }
}

}  // namespace taut::pulley_worlds
