// Connectors that are joined, with answers known beforehand.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/physics/material/material_worlds.h"

namespace taut::joined_worlds {

/// A rope from a fixed point aslant, with two branches that leave it in other directions.
inline World branch(std::size_t particles) {
  World world;
  const Vec3 fork = Vec3(0.4, -0.3, 0);
  Connector trunk = straight_connector("trunk", 0.5, 0.2, particles, Vec3::Zero(), fork);
  trunk.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  const Connector left =
      straight_connector("left", 0.3, 0.1, particles, fork, Vec3(1, -1, 1).normalized());
  Connector right =
      straight_connector("right", 0.4, 0.15, particles, fork, Vec3(0.2, -1, -1).normalized());
  right.particle_mass.back() += 0.05;
  world.connectors = {trunk, left, right};
  world.joints = {{{{0, particles - 1}, {1, 0}, {2, 0}}}};
  finish(world);
  return world;
}

/// A closed loop: a regular polygon of `sides` links about the origin, across z.
inline World ring(std::size_t sides, double radius, double mass) {
  World world;
  world.gravity.setZero();
  const double n = static_cast<double>(sides);
  const double link = 2 * radius * std::sin(std::numbers::pi / n);
  Connector loop =
      straight_connector("loop", n * link, mass, sides + 1, Vec3::Zero(), Vec3::UnitX());
  // The first and the last particle are one: a half for either.
  loop.particle_mass.assign(sides + 1, mass / n);
  loop.particle_mass.front() = loop.particle_mass.back() = mass / n / 2;
  for (std::size_t i = 0; i <= sides; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i % sides) / n;
    loop.position[i] = radius * Vec3(std::cos(angle), std::sin(angle), 0);
  }
  world.connectors = {loop};
  world.joints = {{{{0, 0}, {0, sides}}}};
  finish(world);
  return world;
}

/// The same, turning at `spin` (rad/s).
inline World spinning_ring(std::size_t sides, double radius, double mass, const Vec3& spin) {
  World world = ring(sides, radius, mass);
  Connector& loop = world.connectors[0];
  for (std::size_t i = 0; i <= sides; ++i) loop.velocity[i] = spin.cross(loop.position[i]);
  return world;
}

/// A net of `knots` x `knots`, hung from two of its corners, folded like paper so that it is
/// narrower than its cords are long.
inline World net(std::size_t knots, double width) {
  World world;
  const std::size_t n = knots;
  const double link = width / static_cast<double>(n - 1), fold = 0.4;
  const auto knot = [&](std::size_t i, std::size_t k) -> Vec3 {
    return Vec3(static_cast<double>(i) * std::cos(fold), (i % 2 == 0 ? 0 : 1) * std::sin(fold),
                static_cast<double>(k)) *
           link;
  };
  for (const bool across : {false, true}) {
    for (std::size_t k = 0; k < n; ++k) {
      Connector cord = straight_connector("cord", width, 0.01 * static_cast<double>(n), n,
                                          Vec3::Zero(), Vec3::UnitX());
      for (std::size_t i = 0; i < n; ++i) cord.position[i] = across ? knot(k, i) : knot(i, k);
      if (!across && k == 0) {
        cord.holds = {{0, worlds::fixed_at(knot(0, 0))}, {n - 1, worlds::fixed_at(knot(n - 1, 0))}};
      }
      world.connectors.push_back(cord);
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < n; ++i) world.joints.push_back({{{k, i}, {n + i, k}}});
  }
  finish(world);
  return world;
}

/// A rope that hangs aslant from its first particle, as one connector; or as two that are joined at
/// `at`, of the same particles.
inline World rope(std::size_t particles, const Section* made) {
  World world;
  Connector whole =
      straight_connector("rope", 1, 0.2, particles, Vec3::Zero(), Vec3(1, 0, 0.3).normalized());
  whole.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  if (made) whole.sections.assign(particles - 1, *made);
  world.connectors = {whole};
  finish(world);
  return world;
}

inline World in_two(const World& world, std::size_t at) {
  const Connector& whole = world.connectors[0];
  Connector first = whole, second = whole;
  const auto keep = [](auto& items, std::size_t from, std::size_t count) {
    if (items.empty()) return;
    items.erase(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(from));
    items.resize(count);
  };
  const auto take = [&](Connector& part, std::size_t from, std::size_t to) {
    keep(part.position, from, to - from + 1);
    keep(part.velocity, from, to - from + 1);
    keep(part.particle_mass, from, to - from + 1);
    keep(part.rest, from, to - from);
    keep(part.sections, from, to - from);
    part.length = 0;
    for (const double rest : part.rest) part.length += rest;
  };
  take(first, 0, at);
  take(second, at, whole.particles() - 1);
  second.name = "other";
  second.holds.clear();
  first.particle_mass.back() /= 4;  // the parts of the joint's mass need not be equal
  second.particle_mass.front() *= 0.75;
  World divided = world;
  divided.connectors = {first, second};
  divided.joints = {{{{0, at}, {1, 0}}}};
  finish(divided);
  return divided;
}

/// RMS distance of the particles of a rope and of its two parts, m.
inline double apart_in_two(const World& one, const World& two, std::size_t at) {
  World joined = one;
  std::vector<Vec3>& places = joined.connectors[0].position;
  for (std::size_t i = 0; i < places.size(); ++i) {
    places[i] = i <= at ? two.connectors[0].position[i] : two.connectors[1].position[i - at];
  }
  return material_worlds::apart(one, joined);
}

/// How far apart (m) the particles of joints are.
inline double open(const World& world) {
  double most = 0;
  const auto place = [&](const Joint::Particle& at) {
    return world.connectors[at.connector].position[at.particle];
  };
  for (const Joint& joint : world.joints) {
    for (const Joint::Particle& at : joint.particles) {
      most = std::max(most, (place(at) - place(joint.particles.front())).norm());
    }
  }
  return most;
}

}  // namespace taut::joined_worlds
