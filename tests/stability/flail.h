// The flail that a storm of interventions falls upon.
#pragma once

#include <numeric>

#include "tests/physics/worlds.h"

namespace taut {

/// A rope between two boxes, all thrown and spinning, and a stick that flies with it. Nothing pulls
/// from outside, so that momentum changes by the pins alone.
inline World flail(std::size_t particles) {
  World world = worlds::thrown(particles);
  world.gravity.setZero();
  Body stick;
  stick.name = "stick";
  stick.mass_properties = solid_cylinder(0.3, 0.4, 0.03);
  stick.position = Vec3(0.2, 0.05, 0.03);
  stick.velocity = Vec3(0.4, 1, 0.2);
  world.bodies.push_back(stick);
  finish(world);
  return world;
}

/// Of all that there is, in kg.
inline double mass(const World& world) {
  double sum = 0;
  for (const Body& body : world.bodies) sum += body.bare.mass;
  for (const Connector& connector : world.connectors) {
    sum += std::accumulate(connector.particle_mass.begin(), connector.particle_mass.end(), 0.0);
  }
  return sum;
}

}  // namespace taut
