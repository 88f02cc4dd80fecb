// Parts of a world that never meet: what happens to one costs the others nothing.
#include "sim/run/islands.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "sim/motion/path.h"
#include "sim/run/simulation.h"

namespace taut::islands_test {
namespace {

Attachment fixed(const Vec3& point) {
  return {Attachment::Kind::fixed, point, nullptr, 0};
}
Attachment on_body(std::size_t body, const Vec3& point) {
  return {Attachment::Kind::body, point, nullptr, body};
}

/// A rope of 1 m that hangs askew from what holds it.
Connector rope(const Attachment& from, const Vec3& start) {
  Connector rope = straight_connector("rope", 1, 0.1, 5, start, Vec3(0.6, -0.8, 0));
  rope.holds = {{0, from}};
  return rope;
}

/// So many ropes, each pinned in its middle at a time of its own, or cut, between 0.1 and 0.5 s.
World ropes(std::size_t count, bool pins, Timeline& timeline) {
  World world;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 start(0.1 * double(i), 0, 0);
    world.connectors.push_back(rope(fixed(start), start));
    const double time = 0.1 + 0.4 * (double(i) + 0.3) / double(count);
    if (pins) timeline.pins.push_back({.connector = i, .along = 0.5, .from = time, .to = {}});
    if (!pins) timeline.cuts.push_back({.connector = i, .along = 0.4, .time = time});
  }
  finish(world);
  return world;
}

std::uint64_t steps(std::size_t count, bool pins, std::string_view method) {
  Timeline timeline;
  const World world = ropes(count, pins, timeline);
  Simulation simulation(world, make_method(method, {}), timeline);
  for (int frame = 1; frame <= 6; ++frame) simulation.advance_to(frame / 10.0);
  return simulation.method().counters().steps;
}

TEST(Islands, StepsGrowAsTheNumberOfEventsDoes) {
  for (const char* method : {"direct", "impulse", "truth"}) {
    for (const bool pins : {true, false}) {
      const double few = double(steps(5, pins, method)), many = double(steps(40, pins, method));
      EXPECT_LT(many / few, 8 * 1.2) << method << pins;  // 64 where each event stops all
    }
  }
}

/// A driven stick, ropes and free bodies; a timeline's events on all ropes but the last.
struct Mixed {
  World world;
  Timeline timeline;

  Mixed() {
    Body stick, ball, stone;
    stick.mass_properties = solid_cylinder(0.1, 0.4, 0.02);
    stick.path = std::make_shared<const Path>(
        std::vector<PathKey>{{0, {0, 0, 0}}, {0.3, {0.05, 0, 0}}, {1, {0, 0.1, 0}}});
    ball.mass_properties = solid_sphere(0.2, 0.1);
    ball.position = Vec3(2.6, -0.8, 0);
    stone.mass_properties = solid_sphere(0.3, 0.1);
    stone.velocity = Vec3(0, 1, 0);
    world.bodies = {stick, ball, stone};
    world.connectors = {rope(on_body(0, Vec3::Zero()), Vec3::Zero()),
                        rope(fixed(Vec3(2, 0, 0)), Vec3(2, 0, 0)),
                        rope(on_body(0, Vec3(0, 0.1, 0)), Vec3(0, 0.1, 0)),
                        rope(fixed(Vec3(4, 0, 0)), Vec3(4, 0, 0))};
    world.connectors[1].holds.push_back({4, on_body(1, Vec3::Zero())});
    finish(world);
    timeline.pins = {{.connector = 0, .along = 0.45, .from = 0.11, .until = 0.3, .to = {}},
                     {.connector = 2, .along = 0.5, .from = 0.11, .to = {}},
                     {.connector = 1, .along = 0.5, .from = 0.17, .until = 0.32, .to = {}}};
    timeline.cuts = {{.connector = 2, .along = 0.8, .time = 0.2},
                     {.connector = 0, .along = 0.7, .time = 0.2}};
  }

  /// The rope alone, with what it holds and what happens to it.
  Mixed only(std::size_t rope) const {
    Mixed one = *this;
    one.world.connectors = {world.connectors[rope]};
    const auto other = [&](const auto& entry) { return entry.connector != rope; };
    std::erase_if(one.timeline.pins, other);
    std::erase_if(one.timeline.cuts, other);
    for (TimedPin& pin : one.timeline.pins) pin.connector = 0;
    for (TimedCut& cut : one.timeline.cuts) cut.connector = 0;
    const Body ball = world.bodies[1];
    one.world.bodies = {world.bodies[0]};
    if (rope == 1) {
      one.world.bodies.push_back(ball);
      one.world.bodies[1].mass_properties = ball.bare;
    }
    one.world.topology = 0;
    return one;
  }
};

TEST(Islands, MoveAsIfEachWasAlone) {
  const Mixed mixed;
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty() || method.name == "sdfast") continue;  // made for a rope beforehand
    Simulation all(mixed.world, make_method(method.name, {}), mixed.timeline);
    for (int frame = 1; frame <= 4; ++frame) all.advance_to(frame / 10.0);
    const Snapshot moved = all.state();
    ASSERT_EQ(moved.connectors.size(), 6u);
    // A small world has room made for what comes, and then `direct` projects velocities that fit.
    const double same = method.name == "direct" ? 1e-9 : 0;
    // The parts cut off come last: of the first rope, then of the third.
    const std::vector<std::vector<std::size_t>> parts{{0, 5}, {1}, {2, 4}};
    for (std::size_t rope = 0; rope < 3; ++rope) {
      const Mixed one = mixed.only(rope);
      Simulation alone(one.world, make_method(method.name, {}), one.timeline);
      for (int frame = 1; frame <= 4; ++frame) alone.advance_to(frame / 10.0);
      const Snapshot expected = alone.state();
      ASSERT_EQ(expected.connectors.size(), parts[rope].size());
      for (std::size_t k = 0; k < parts[rope].size(); ++k) {
        const std::vector<Vec3>&is = moved.connectors[parts[rope][k]],
              &was = expected.connectors[k];
        ASSERT_EQ(is.size(), was.size());
        for (std::size_t i = 0; i < is.size(); ++i) {
          EXPECT_LE((is[i] - was[i]).norm(), same) << method.name << rope << k << i;
        }
      }
    }
    const World& world = std::as_const(all).world();
    EXPECT_EQ(world.topology, structure(world)) << method.name;
    EXPECT_EQ(world.time, 0.4);
    EXPECT_EQ(world.bodies[0].point(Vec3::Zero()), world.connectors[0].position[0]) << method.name;
    EXPECT_NEAR(world.bodies[2].position.y(), 0.4 - 9.81 * 0.08, 3e-3) << method.name;
  }
}

TEST(Islands, WhatIsChangedByHandTiesThemTogether) {
  const Mixed mixed;
  const Settings fine{{"tolerance", 1e-8}};
  const MethodInfo& direct = *find_method("direct");
  // Nobody says how to make another one of the second: one method steps the whole world.
  Simulation islands(mixed.world, make_method("direct", fine), mixed.timeline);
  Simulation whole(mixed.world, direct.make(with_defaults(direct, fine)), mixed.timeline);
  for (Simulation* simulation : {&islands, &whole}) {
    simulation->advance_to(0.15);
    World& world = simulation->world();
    const Vec3 there = world.connectors[3].position[4];
    ASSERT_EQ(simulation->interventions().pin(world, 3, 1, fixed(there)).outcome, Outcome::done);
    ASSERT_EQ(simulation->interventions().pin(world, 1, 0.25, on_body(2, Vec3::Zero())).outcome,
              Outcome::out_of_reach);
    simulation->advance_to(0.4);
  }
  const Snapshot a = islands.state(), b = whole.state();
  for (std::size_t c = 0; c < b.connectors.size(); ++c) {
    for (std::size_t i = 0; i < b.connectors[c].size(); ++i) {
      EXPECT_LT((a.connectors[c][i] - b.connectors[c][i]).norm(), 1e-6) << c << i;
    }
  }
}

TEST(Islands, EventsComeInTheOrderOfTheirTimes) {
  World world;
  Timeline timeline;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 start(double(i), 0, 0);
    Connector cord = straight_connector("cord", 1, 0, 2, start, Vec3(0, -1, 0));
    cord.model = ConnectorModel::span;
    Body ball;
    ball.mass_properties = solid_sphere(0.2, 0.1);
    ball.position = start - Vec3(0, 0.9 - 0.1 * double(i), 0);
    cord.holds = {{0, fixed(start)}, {1, on_body(i, Vec3::Zero())}};
    world.bodies.push_back(ball);
    world.connectors.push_back(cord);
    world.connectors.push_back(rope(fixed(start), start));
    timeline.cuts.push_back({.connector = 2 * i + 1, .along = 0.5, .time = 0.05});
  }
  finish(world);
  Simulation simulation(world, make_method("direct", {}), timeline);
  simulation.advance_to(0.5);
  const std::vector<Event>& events = simulation.method().events();
  ASSERT_GE(events.size(), 4u);
  EXPECT_TRUE(std::ranges::is_sorted(events, {}, &Event::time));
  std::vector<std::size_t> taut;
  for (const Event& event : events) {
    if (event.kind == Event::Kind::taut) taut.push_back(event.connector);
  }
  ASSERT_GE(taut.size(), 4u);
  EXPECT_EQ(taut.front(), 0u);  // the lowest ball comes first
}

TEST(Islands, AnImpossiblePinLeavesAllAtItsTime) {
  Mixed mixed;
  mixed.timeline.pins.push_back(
      {.connector = 0, .along = 0.5, .from = 0.25, .to = fixed({9, 9, 9})});
  Simulation simulation(mixed.world, make_method("direct", {}), mixed.timeline);
  EXPECT_THROW(simulation.advance_to(0.4), BadIntervention);
  const World& world = std::as_const(simulation).world();
  EXPECT_EQ(world.time, 0.25);
  EXPECT_NEAR(world.bodies[2].position.y(), 0.25 - 9.81 * 0.25 * 0.25 / 2, 1e-6);
}

}  // namespace
}  // namespace taut::islands_test
