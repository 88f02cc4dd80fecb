// Small worlds with known or easily bounded motion, shared by tests of methods and of the truth.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "sim/world/world.h"

namespace taut::worlds {

constexpr double kGravity = 9.81;  // m/s^2, World's default

inline Attachment fixed_at(const Vec3& point) {
  Attachment to;
  to.point = point;
  return to;
}

inline Attachment on_body(std::size_t body, const Vec3& point) {
  Attachment to;
  to.kind = Attachment::Kind::body;
  to.body = body;
  to.point = point;
  return to;
}

inline Attachment on_path(std::shared_ptr<const Path> path) {
  Attachment to;
  to.kind = Attachment::Kind::path;
  to.path = std::move(path);
  return to;
}

/// A unit vector `degrees` from straight down, in the plane of x and y.
inline Vec3 from_down(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return Vec3(std::sin(angle), -std::cos(angle), 0);
}

/// `particles` of a kilogram in all on a line from the origin, the first fixed.
inline World chain(std::size_t particles, double length, const Vec3& direction, double mass = 1) {
  World world;
  Connector connector =
      straight_connector("chain", length, mass, particles, Vec3::Zero(), direction.normalized());
  connector.holds = {{0, fixed_at(Vec3::Zero())}};
  world.connectors = {connector};
  finish(world);
  return world;
}

/// One bead on one link of `length` (m), released at rest.
inline World pendulum(double length, double degrees) {
  return chain(2, length, from_down(degrees));
}

/// The pendulum's period over 2 pi sqrt(L/g): 1 / arithmetic-geometric mean of 1, cos(angle/2).
inline double period_ratio(double degrees) {
  double a = 1, g = std::cos(degrees * std::numbers::pi / 360);
  while (std::abs(a - g) > 1e-15) {
    const double mean = (a + g) / 2;
    g = std::sqrt(a * g);
    a = mean;
  }
  return 1 / a;
}

/// By how much a soft link lengthens that period, relative, per stretch m g / (k l): the pull
/// F = m g (3 cos a - 2 cos A) stretches it by F/k, which adds F^2/2k to the Lagrangian, and the
/// period changes by d/dE of its integral over a period.
inline double softening(double degrees) {
  // Integral of (F/mg)^2 dt sqrt(g/l) over a period, with sin(a/2) = sin(A/2) sin(p).
  const auto integral = [](double amplitude) {
    constexpr int steps =
        64;  // the midpoint rule, exact to rounding for a smooth periodic integrand
    const double bottom = std::cos(amplitude), k = std::sin(amplitude / 2);
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
      const double half = k * std::sin(2 * std::numbers::pi * (i + 0.5) / steps);
      const double pull = 3 * (1 - 2 * half * half) - 2 * bottom;
      sum += pull * pull / std::sqrt(1 - half * half);
    }
    return 2 * std::numbers::pi / steps * sum;
  };
  const double amplitude = degrees * std::numbers::pi / 180, step = 1e-4;
  // E = -m g l cos A, so that dE = m g l sin A dA.
  const double slope = (integral(amplitude + step) - integral(amplitude - step)) / (2 * step);
  return slope / std::sin(amplitude) / 2 / (2 * std::numbers::pi * period_ratio(degrees));
}

/// A box, neither symmetric nor held at its centre, that starts with a spin.
inline Body box(const std::string& name) {
  Body body;
  body.name = name;
  body.mass_properties = solid_box(0.3, Vec3(0.06, 0.2, 0.1));
  body.spin = Vec3(0.5, 2, 1);
  return body;
}

/// A chain whose last particle is held by a box at a point off its axes.
inline World chain_with_box(std::size_t particles) {
  World world;
  const Vec3 direction = from_down(60), point(0.02, 0.1, 0.03);
  Body body = box("box");
  Connector connector = straight_connector("chain", 0.4, 0.2, particles, Vec3::Zero(), direction);
  body.position = connector.position.back() - point;
  body.velocity = -body.spin.cross(point);  // the point of attachment is at rest
  world.bodies = {body};
  connector.holds = {{0, fixed_at(Vec3::Zero())}, {particles - 1, on_body(0, point)}};
  world.connectors = {connector};
  finish(world);
  return world;
}

/// A chain that hangs from a hand, which goes sideways and turns.
inline World driven_chain(std::size_t particles) {
  World world;
  std::vector<PathKey> keys(3);
  for (std::size_t k = 0; k < 3; ++k) {
    keys[k].time = 0.25 * static_cast<double>(k);
    keys[k].ease = k != 1;
  }
  keys[1].position = Vec3(0.1, 0.05, 0.02);
  keys[1].rotation = Quat(Eigen::AngleAxisd(0.8, Vec3(0, 0.6, 0.8)));
  keys[2].position = Vec3(0.3, 0, 0.1);
  Body hand;
  hand.name = "hand";
  hand.mass_properties = solid_cylinder(0.12, 0.3, 0.03);
  hand.path = std::make_shared<const Path>(keys);
  world.bodies = {hand};
  Connector connector =
      straight_connector("chain", 0.4, 0.2, particles, Vec3(0, -0.15, 0), -Vec3::UnitY());
  connector.holds = {{0, on_body(0, Vec3(0, -0.15, 0))}};
  connector.particle_mass.back() += 0.1;  // a point mass
  world.connectors = {connector};
  finish(world);
  return world;
}

/// Two boxes joined by a chain, thrown and spinning.
inline World thrown(std::size_t particles) {
  World world;
  Body left = box("left"), right = box("right");
  const Vec3 point(0, 0.1, 0.02);
  Connector connector =
      straight_connector("chain", 0.4, 0.2, particles, Vec3::Zero(), Vec3::UnitX());
  left.position = connector.position.front() - point;
  right.position = connector.position.back() - point;
  const Vec3 throwing(0.4, 1, 0.2), turning(0.5, -1, 3);  // as one rigid thing at first
  for (Body* body : {&left, &right}) {
    body->spin = turning;
    body->velocity = throwing + turning.cross(body->position);
  }
  for (std::size_t i = 0; i < particles; ++i) {
    connector.velocity[i] = throwing + turning.cross(connector.position[i]);
  }
  world.bodies = {left, right};
  connector.holds = {{0, on_body(0, point)}, {particles - 1, on_body(1, point)}};
  world.connectors = {connector};
  finish(world);
  return world;
}

/// A garland with a pin, a box at its end, and a stay from the box to a third fixed point: spans,
/// several connectors, and a body that carries two points.
inline World garland() {
  World world;
  Connector chain = straight_connector("chain", 0.6, 0.2, 13, Vec3::Zero(), Vec3(4, -3, 0) / 5);
  for (std::size_t i = 4; i <= 12; ++i) {  // up again to the pin, then down to the box
    const double beyond = 0.05 * (static_cast<double>(i) - 6);
    chain.position[i] =
        Vec3(0.24, 0, 0) + (i < 6 ? Vec3(0.8, 0.6, 0) * beyond : Vec3(0, -beyond, 0));
  }
  Body body = box("box");
  body.spin.setZero();
  const Vec3 top(0.03, 0.1, 0), side(0, -0.1, 0.05);
  body.position = chain.position[12] - top;
  const Vec3 stays = body.position + side;
  Connector stay = straight_connector("stay", 0.3, 0.1, 5, stays, Vec3::UnitX());
  world.bodies = {body};
  chain.holds = {
      {0, fixed_at(Vec3::Zero())}, {6, fixed_at(Vec3(0.24, 0, 0))}, {12, on_body(0, top)}};
  stay.holds = {{0, on_body(0, side)}, {4, fixed_at(stays + Vec3(0.3, 0, 0))}};
  world.connectors = {chain, stay};
  finish(world);
  return world;
}

/// Of all that moves freely, in kg.
inline double total_mass(const World& world) {
  double mass = 0;
  for (const Connector& connector : world.connectors) {
    for (const double particle : connector.particle_mass) mass += particle;
  }
  for (const Body& body : world.bodies) mass += body.driven() ? 0 : body.bare.mass;
  return mass;
}

}  // namespace taut::worlds
