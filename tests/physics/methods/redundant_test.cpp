// Bodies that links hold more often than they can move: the motion is known, the tensions are of
// least norm.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::redundant_test {
namespace {

constexpr double kLength = 1.0;  // m

/// A board, level and in motion sideways, on ropes of one link to its rim, which stay parallel: its
/// centre is a pendulum of their length.
World board(std::size_t ropes, double speed, bool pulls = false) {
  World world;
  Body made;
  made.name = "board";
  made.mass_properties = solid_box(5, Vec3(1, 0.1, 1));
  made.position = Vec3(0, -kLength, 0);
  made.velocity = Vec3(speed, 0, 0);
  world.bodies = {made};
  for (std::size_t k = 0; k < ropes; ++k) {
    const double angle = 2 * std::numbers::pi * (static_cast<double>(k) + 0.3) / double(ropes);
    const Vec3 rim(0.5 * std::cos(angle), 0, 0.5 * std::sin(angle));
    Connector rope =
        straight_connector(fmt::format("rope{}", k), kLength, 0.02, 2, rim, -Vec3::UnitY());
    rope.velocity[1] = made.velocity;
    rope.pulls = pulls;
    rope.holds = {{0, worlds::fixed_at(rim)}, {1, worlds::on_body(0, rim)}};
    world.connectors.push_back(rope);
  }
  finish(world);
  return world;
}

/// The angle of a pendulum that passes its lowest place at `rate` (1/s), after `time` (s).
double pendulum(double rate, double time) {
  double angle = 0;
  constexpr int kSteps = 20000;
  const double h = time / kSteps;
  for (int i = 0; i < kSteps; ++i) {  // leapfrog
    angle += h / 2 * rate;
    rate -= h * worlds::kGravity / kLength * std::sin(angle);
    angle += h / 2 * rate;
  }
  return angle;
}

/// Checks the board after 0.9 s, between its turns.
void expect_pendulum(const World& start, const char* method, const Settings& settings,
                     double within) {
  Simulation simulation(start, make_method(method, settings));
  for (int k = 1; k <= 45; ++k) simulation.advance_to(k / 50.0);
  const double angle = pendulum(start.bodies[0].velocity.x(), 0.9);
  const Body& board = std::as_const(simulation).world().bodies[0];
  const Vec3 right(kLength * std::sin(angle), -kLength * std::cos(angle), 0);
  EXPECT_LT((board.position - right).norm(), within) << method << start.connectors.size();
  EXPECT_LT(board.rotation.vec().norm(), within) << method << start.connectors.size();
}

TEST(Redundant, ABoardOnManyRopesIsAPendulum) {
  for (const std::size_t ropes : {3u, 4u, 5u, 8u}) {
    expect_pendulum(board(ropes, 1), "direct", {{"tolerance", 1e-6}}, 1e-5);
  }
  expect_pendulum(board(4, 1), "truth", {}, 1e-7);
  expect_pendulum(board(4, 1), "dynamic-constraints", {{"step", 1e-4}}, 1e-3);
}

TEST(Redundant, ABoardOnManyStringsIsAPendulum) {
  for (const std::size_t strings : {4u, 5u}) {
    expect_pendulum(board(strings, 1, true), "direct", {{"tolerance", 1e-5}}, 1e-3);
  }
}

// A second rope of one link between the same places, and a lighter one.
TEST(Redundant, ASecondRopeBetweenTheSamePlacesChangesNothing) {
  const auto held_by = [](std::initializer_list<double> masses) {
    World world;
    Body body = worlds::box("box");
    body.position = Vec3(0.3, -0.6, 0.1);
    const Vec3 point(0.02, 0.08, 0.03);
    const Vec3 from(0, 0, 0), to = body.point(point);
    body.spin = Vec3::Zero();
    world.bodies = {body};
    for (const double mass : masses) {
      Connector rope = straight_connector(mass > 0.01 ? "heavy" : "light", (to - from).norm(), mass,
                                          2, from, to - from);
      rope.holds = {{0, worlds::fixed_at(from)}, {1, worlds::on_body(0, point)}};
      world.connectors.push_back(rope);
    }
    finish(world);
    return world;
  };
  const World world = held_by({0.02, 0.001}), one = held_by({0.021});
  for (const auto& [method, settings] :
       {std::pair<const char*, Settings>{"direct", {{"tolerance", 1e-7}}}, {"truth", {}}}) {
    Simulation twice(world, make_method(method, settings)),
        once(one, make_method(method, settings));
    twice.advance_to(0.5);
    once.advance_to(0.5);
    const World &a = std::as_const(twice).world(), &b = std::as_const(once).world();
    EXPECT_LT((a.bodies[0].position - b.bodies[0].position).norm(), 1e-5) << method;
  }
}

}  // namespace
}  // namespace taut::redundant_test
