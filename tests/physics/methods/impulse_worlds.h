// Small worlds for the tests of the impulse method: sticks, cords, a pendulum.
#pragma once

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"

namespace taut {

inline constexpr double kGravity = 9.81;

inline Attachment fixed(const Vec3& point) {
  return {Attachment::Kind::fixed, point, nullptr, 0};
}
inline Attachment on_body(std::size_t body, const Vec3& point) {
  return {Attachment::Kind::body, point, nullptr, body};
}

inline Body stick(const Vec3& centre, const Vec3& velocity, const Vec3& spin = Vec3::Zero()) {
  Body body;
  body.name = "stick";
  body.mass_properties = solid_cylinder(0.12, 0.3, 0.028);
  body.position = centre;
  body.velocity = velocity;
  body.spin = spin;
  return body;
}

/// A cord of which only the ends matter at first: its particles lie between `from` and `to`.
inline Connector cord(double length, double mass, std::size_t particles, const Vec3& from,
                      const Vec3& to) {
  Connector made = straight_connector("cord", length, mass, particles, from, Vec3::UnitX());
  for (std::size_t i = 0; i < particles; ++i) {
    made.position[i] =
        from + static_cast<double>(i) / static_cast<double>(particles - 1) * (to - from);
  }
  return made;
}

/// A particle of 0.5 kg on a cord of 1 m from the origin, which has no mass, no other particle.
inline World pendulum(const Vec3& place) {
  World world;
  Connector line = cord(1, 0, 2, Vec3::Zero(), place);
  line.holds = {{0, fixed(Vec3::Zero())}};
  line.particle_mass[1] = 0.5;
  world.connectors = {line};
  finish(world);
  return world;
}

inline World two_sticks(double restitution, double cord_mass = 0) {
  World world;
  world.bodies = {stick(Vec3(0, 0, 0), Vec3(0.2, 1.5, 0), Vec3(1, 2, 3)),
                  stick(Vec3(0.05, -0.45, 0), Vec3(-0.1, -1, 0.4), Vec3(-2, 1, 4))};
  world.bodies[1].mass_properties = solid_cylinder(0.3, 0.3, 0.03);
  Connector line = cord(0.2, cord_mass, 5, world.bodies[0].point(Vec3(0, -0.15, 0)),
                        world.bodies[1].point(Vec3(0, 0.15, 0)));
  line.holds = {{0, on_body(0, Vec3(0, -0.15, 0))}, {4, on_body(1, Vec3(0, 0.15, 0))}};
  line.restitution = restitution;
  world.connectors = {line};
  return world;
}

}  // namespace taut
