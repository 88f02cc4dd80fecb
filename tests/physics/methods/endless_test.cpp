// Runs that went on without end: each ends, with an answer or by saying where it cannot go on.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::endless_test {
namespace {

/// Whether the run gets to `time` (s); else it names what stops it.
bool gets_to(const World& world, const char* method, const Settings& settings, double time) {
  Simulation simulation(world, make_method(method, settings));
  try {
    for (int k = 1; k <= 60 * time; ++k) simulation.advance_to(k / 60.0);
  } catch (const Diverged& error) {
    EXPECT_EQ(error.connector, world.connectors[0].name) << error.what();
    return false;
  }
  return true;
}

/// A trunk and a branch that is joined to its middle.
World fork() {
  World world;
  Connector trunk = straight_connector("trunk", 0.9, 0.21, 7, Vec3(0, 1, 0), Vec3::UnitX());
  trunk.holds = {{0, worlds::fixed_at(Vec3(0, 1, 0))}};
  Connector branch =
      straight_connector("branch", 0.47, 0.06, 4, Vec3(0.45, 1, 0), Vec3(0, 1, 0.3).normalized());
  world.connectors = {trunk, branch};
  world.joints = {{{{0, 3}, {1, 0}}}};
  finish(world);
  return world;
}

// A fixed step that its own error refuses is done in shorter ones.
TEST(Endless, AFixedStepOfJoinedConnectorsEnds) {
  const World start = fork();
  EXPECT_TRUE(gets_to(start, "direct", {{"step", 1.0 / 60}}, 1));
  Simulation coarse(start, make_method("direct", {{"step", 1.0 / 60}}));
  Simulation fine(start, make_method("direct", {{"tolerance", 1e-6}}));
  coarse.advance_to(0.2);
  fine.advance_to(0.2);
  const auto tip = [](Simulation& simulation) {
    return std::as_const(simulation).world().connectors[0].position.back();
  };
  EXPECT_LT((tip(coarse) - tip(fine)).norm(), 0.01);
}

TEST(Endless, ARopeHeldAtItsFullLengthEnds) {
  for (const std::size_t particles : {3u, 4u, 17u}) {
    const double length = 0.12766466077469402;
    World world = worlds::chain(particles, length, Vec3::UnitX(), 0.0045);
    world.connectors[0].holds.push_back({particles - 1, worlds::fixed_at(Vec3(length, 0, 0))});
    world.topology = 0;
    finish(world);
    for (const char* method : {"direct", "truth"}) gets_to(world, method, {}, 0.1);
  }
}

TEST(Endless, MoreStepsThanARunCanTakeAreRefused) {
  const World world = worlds::chain(3, 0.5, Vec3::UnitX());
  for (const char* method : {"direct", "impulse", "springs", "xpbd", "dynamic-constraints"}) {
    for (const double step : {1e-300, 1e-30, 1e-20, 1e-13}) {
      Simulation simulation(world, make_method(method, {{"step", step}}));
      EXPECT_THROW(simulation.advance_to(1), std::invalid_argument) << method << step;
    }
  }
  EXPECT_NE(step_complaint({{"step", 1e-30}}, 1), "");
  EXPECT_EQ(step_complaint({{"step", 1e-9}}, 1), "");
  EXPECT_EQ(step_complaint({{"step", 0.0}}, 1), "");
  EXPECT_EQ(step_complaint({{"tolerance", 1e-9}}, 1), "");
}

// A pin to a free body hands the world over to another integrator, which counts on.
TEST(Endless, CountersNeverRunBackwards) {
  World world = worlds::chain(11, 0.5, Vec3::UnitX());
  world.gravity = Vec3::Zero();
  world.connectors[0].sections.assign(10, Section{.bending_stiffness = 1e-3});
  world.connectors[0].velocity[5] = Vec3(0, 0.01, 0);
  Body body = worlds::box("box");
  body.spin = Vec3::Zero();
  body.position = Vec3(0.5, 0, 0);
  world.bodies = {body};
  world.topology = 0;
  finish(world);
  Timeline timeline;
  TimedPin pin;
  pin.along = 0.5;
  pin.from = 0.2;
  pin.until = 0.4;
  pin.to = worlds::on_body(0, Vec3::Zero());
  pin.over = 0.01;
  timeline.pins = {pin};
  Simulation simulation(world, make_method("direct", {}), timeline);
  Counters before;
  for (int k = 1; k <= 30; ++k) {
    simulation.advance_to(k / 60.0);
    const Counters& now = simulation.method().counters();
    EXPECT_GE(now.steps, before.steps) << k;
    EXPECT_GE(now.solves, before.solves) << k;
    EXPECT_GE(now.cycles, before.cycles) << k;
    before = now;
  }
  EXPECT_GT(before.steps, 0u);
}

}  // namespace
}  // namespace taut::endless_test
