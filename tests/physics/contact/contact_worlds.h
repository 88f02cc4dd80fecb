// Worlds whose contacts have known answers.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sim/contact/capsule.h"
#include "sim/motion/rotation.h"
#include "sim/run/simulation.h"
#include "sim/world/obstacle.h"
#include "tests/physics/worlds.h"

namespace taut::contact_worlds {

inline Obstacle obstacle(const Shape& shape, double friction = 0, double restitution = 0) {
  Obstacle made;
  made.name = "obstacle";
  made.shape = shape;
  made.static_friction = made.kinetic_friction = friction;
  made.restitution = restitution;
  return made;
}

/// A cylinder along the world's z axis.
inline Obstacle post(double radius, const Vec3& at, double friction = 0) {
  Obstacle made = obstacle(cylinder_shape(radius, 1), friction);
  made.place = {at, rotation_between(Vec3::UnitY(), Vec3::UnitZ())};
  return made;
}

/// Two particles that move as one, a link of 0.1 m along z between them.
inline World pair(const Vec3& at, const Vec3& velocity, const Obstacle& obstacle) {
  World world;
  Connector link = straight_connector("pair", 0.1, 0.2, 2, at, Vec3::UnitZ());
  for (Vec3& v : link.velocity) v = velocity;
  world.connectors = {link};
  world.obstacles = {obstacle};
  finish(world);
  return world;
}

inline Simulation by_direct(const World& world, double tolerance = 1e-4) {
  return {world, make_method("direct", {{"tolerance", tolerance}})};
}

/// The deepest that a bead which nothing holds is in an obstacle, m.
inline double penetration(const World& world) {
  double deepest = 0;
  for (const Obstacle& obstacle : world.obstacles) {
    const Pose frame = obstacle.frame(world.time).pose();
    for (const Connector& connector : world.connectors) {
      for (std::size_t i = 0; i < connector.particles(); ++i) {
        const bool held = std::ranges::any_of(connector.holds,
                                              [&](const Hold& hold) { return hold.particle == i; });
        if (held) continue;
        const double apart = gap(obstacle, frame, connector.position[i], connector.radius).distance;
        deepest = std::max(deepest, -apart);
      }
    }
  }
  return deepest;
}

/// The deepest that a link between beads is in an obstacle, m; of links that touch.
inline double penetration_of_links(const World& world) {
  double deepest = 0;
  for (const Obstacle& obstacle : world.obstacles) {
    const Pose frame = obstacle.frame(world.time).pose();
    for (const Connector& connector : world.connectors) {
      for (std::size_t i = 0; connector.links_touch && i + 1 < connector.particles(); ++i) {
        const contact::Capsule link{connector.position[i], connector.position[i + 1],
                                    connector.radius};
        deepest = std::max(deepest, -contact::least_gap(obstacle.shape, frame, link));
      }
    }
  }
  return deepest;
}

/// m/s.
inline double fastest(const World& world) {
  double most = 0;
  for (const Connector& connector : world.connectors) {
    for (const Vec3& velocity : connector.velocity) most = std::max(most, velocity.norm());
  }
  return most;
}

/// A rope of a metre that falls aslant on what is below.
inline World falling_rope(std::size_t particles, const Obstacle& below) {
  World world;
  Connector rope =
      straight_connector("rope", 1, 0.1, particles, Vec3(0, 1.2, 0), Vec3(0.6, -0.8, 0));
  rope.radius = 0.005;
  world.connectors = {rope};
  world.obstacles = {below};
  finish(world);
  return world;
}

/// A chain of links of `link` (m) that hangs down on both sides of a post, over which it lies with
/// `arc` chords to half a turn, and `turns` whole turns more. All its arc's particles touch.
inline World over_post(std::size_t arc, std::size_t turns, std::size_t left, std::size_t right,
                       double link, double mass, double friction) {
  const double half = std::numbers::pi / static_cast<double>(arc);
  const double radius = link / (2 * std::sin(half / 2));
  const std::size_t chords = (2 * turns + 1) * arc, particles = left + chords + right + 1;
  Connector chain = straight_connector("chain", link * static_cast<double>(particles - 1), mass,
                                       particles, Vec3::Zero(), Vec3::UnitX());
  for (std::size_t i = 0; i < particles; ++i) {
    if (i < left) {
      chain.position[i] = Vec3(-radius, -link * static_cast<double>(left - i), 0);
    } else if (i <= left + chords) {
      const double angle = std::numbers::pi - half * static_cast<double>(i - left);
      chain.position[i] = radius * Vec3(std::cos(angle), std::sin(angle), 0);
    } else {
      chain.position[i] = Vec3(radius, -link * static_cast<double>(i - left - chords), 0);
    }
  }
  World world;
  world.connectors = {chain};
  world.obstacles = {post(radius, Vec3::Zero(), friction)};
  finish(world);
  return world;
}

}  // namespace taut::contact_worlds
