// Sticks and balls that touch obstacles and each other.
#pragma once

#include <numbers>
#include <utility>
#include <vector>

#include "contact_worlds.h"
#include "sim/contact/capsule.h"
#include "tests/support/dice.h"

namespace taut::contact_sticks {

using namespace contact_worlds;
using worlds::kGravity;

inline constexpr double kLength = 0.4, kRadius = 0.01, kMass = 0.3;  // m, m, kg
inline constexpr double kAcross = kMass * kLength * kLength / 12;    // kg m^2, of a thin rod
inline constexpr double kAlong = kMass * kRadius * kRadius / 2;

/// A thin rod between the centres of its ends, along the y axis.
inline Body rod(const Vec3& centre, const Vec3& velocity = Vec3::Zero()) {
  Body body;
  body.name = "rod";
  body.mass_properties = {kMass, Vec3::Zero(), Vec3(kAcross, kAlong, kAcross).asDiagonal()};
  body.capsule = {kRadius, -kLength / 2 * Vec3::UnitY(), kLength / 2 * Vec3::UnitY()};
  body.position = centre;
  body.velocity = velocity;
  return body;
}

/// A rod along x, turned up by `angle` (rad).
inline Body leaning(const Vec3& centre, double angle) {
  Body body = rod(centre);
  body.rotation = Quat(Eigen::AngleAxisd(angle - std::numbers::pi / 2, Vec3::UnitZ()));
  return body;
}

inline Body turned(Body body, const Vec3& to) {
  body.rotation = rotation_between(Vec3::UnitY(), to);
  return body;
}

inline Body ball(const Vec3& centre, const Vec3& velocity) {
  Body body;
  body.name = "ball";
  body.mass_properties = solid_sphere(kMass, 2 * kRadius);
  body.capsule.radius = kRadius;
  body.position = centre;
  body.velocity = velocity;
  return body;
}

inline World with(const Body& body, const Obstacle& obstacle) {
  World world;
  world.bodies = {body};
  world.obstacles = {obstacle};
  finish(world);
  return world;
}

inline Obstacle incline(double angle, double friction) {
  Obstacle made = obstacle(plane_shape(), friction);
  made.place.rotation = Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
  return made;
}

/// Bodies of which each touches each other.
inline World among(std::vector<Body> bodies, double friction = 0, double restitution = 0) {
  World world;
  world.gravity.setZero();
  world.bodies = std::move(bodies);
  for (std::size_t a = 0; a < world.bodies.size(); ++a) {
    for (std::size_t b = a + 1; b < world.bodies.size(); ++b) {
      world.pairs.push_back({a, b, friction, friction, restitution});
    }
  }
  finish(world);
  return world;
}

inline contact::Capsule capsule_of(const Body& body) {
  return {body.point(body.capsule.from), body.point(body.capsule.to), body.capsule.radius};
}

/// The deepest that bodies are in each other or in obstacles, m.
inline double depth(const World& world) {
  double deepest = -1;
  for (const BodyPair& pair : world.pairs) {
    deepest = std::max(deepest, -contact::least_gap(capsule_of(world.bodies[pair.a]),
                                                    capsule_of(world.bodies[pair.b])));
  }
  for (const Body& body : world.bodies) {
    for (const Obstacle& with : world.obstacles) {
      const Pose frame = with.frame(world.time).pose();
      deepest = std::max(deepest, -contact::least_gap(with.shape, frame, capsule_of(body)));
    }
  }
  return deepest;
}

/// A ball that comes along x at `speed` (m/s) to one at rest, which it meets along `normal`.
inline World balls_aslant(const Vec3& normal, double speed, double friction, double restitution) {
  const Vec3 before = -2 * kRadius * normal - 0.3 * Vec3::UnitX();
  return among({ball(before, speed * Vec3::UnitX()), ball(Vec3::Zero(), Vec3::Zero())}, friction,
               restitution);
}

/// A rod that slides up an incline of `angle` (rad) at first; static friction would hold it.
inline World rod_pushed_up(double angle, double speed, double kinetic) {
  const Vec3 along(std::cos(angle), std::sin(angle), 0), up(-along.y(), along.x(), 0);
  Body body = leaning(kRadius * up, angle);
  body.velocity = speed * along;
  Obstacle below = incline(angle, kinetic);
  below.static_friction = 1.2 * std::tan(angle);
  return with(body, below);
}

/// Three equal rods along z on a floor: one on top of two that touch.
inline World pile(double friction) {
  const double high = kRadius * (1 + std::sqrt(3.0));
  World world = among({turned(rod(Vec3(-kRadius, kRadius, 0)), Vec3::UnitZ()),
                       turned(rod(Vec3(kRadius, kRadius, 0)), Vec3::UnitZ()),
                       turned(rod(Vec3(0, high, 0)), Vec3::UnitZ())},
                      friction);
  world.gravity = Vec3(0, -kGravity, 0);
  world.obstacles = {obstacle(plane_shape(), friction)};
  finish(world);
  return world;
}

/// Sticks and balls above a floor, each at a height of its own.
inline World storm(unsigned seed) {
  Dice dice(seed);
  std::vector<Body> bodies;
  for (int i = 0; i < 4; ++i) {
    const double radius = dice.between(0.01, 0.03), mass = dice.between(0.05, 0.5);
    const double length = dice.pick(5) == 0 ? 0 : dice.between(0.1, 0.3);
    Body body;
    body.name = "body";
    body.mass_properties = length > 0 ? solid_cylinder(mass, length + 2 * radius, 2 * radius)
                                      : solid_sphere(mass, 2 * radius);
    body.capsule = {radius, -length / 2 * Vec3::UnitY(), length / 2 * Vec3::UnitY()};
    body.position = dice.within(0.1) + (0.5 + 0.6 * i) * Vec3::UnitY();
    body.rotation = rotation_between(Vec3::UnitY(), dice.direction());
    body.spin = dice.within(5);
    bodies.push_back(body);
  }
  const double friction = dice.pick(3) == 0 ? 0 : dice.between(0, 1);
  World world = among(std::move(bodies), friction);
  world.gravity = Vec3(0, -kGravity, 0);
  world.obstacles = {obstacle(plane_shape(), friction)};
  finish(world);
  return world;
}

}  // namespace taut::contact_sticks
