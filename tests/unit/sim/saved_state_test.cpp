// States that are saved, and simulations that go on from them.
#include "sim/run/saved_state.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "sim/motion/hash.h"
#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::saved_state_test {
namespace {

std::shared_ptr<const Path> path(const Vec3& by) {
  std::vector<PathKey> keys(2);
  keys[1].time = 1;
  keys[1].position = by;
  return std::make_shared<const Path>(keys);
}

struct Problem {
  World world;
  Timeline timeline;
};

/// A rope on a path with a body, pinned, let go and cut on the way, beside a rope with bending.
Problem problem() {
  Problem made;
  World& world = made.world;
  Body ball;
  ball.name = "ball";
  ball.mass_properties = solid_sphere(0.3, 0.1);
  ball.position = Vec3(1, -0.05, 0);
  world.bodies = {ball};
  Connector rope = straight_connector("rope", 1, 0.2, 9, Vec3::Zero(), Vec3::UnitX());
  rope.holds = {{0, worlds::on_path(path(Vec3(0, 0.2, 0)))},
                {8, worlds::on_body(0, Vec3(0, 0.05, 0))}};
  Connector rod = straight_connector("rod", 1, 0.2, 6, Vec3(0, 0, 1), Vec3::UnitX());
  rod.holds = {{0, worlds::fixed_at(Vec3(0, 0, 1))}};
  rod.sections.assign(5, Section{.bending_stiffness = 1e-3});
  world.connectors = {rope, rod};
  finish(world);
  made.timeline.pins = {{.connector = 0, .along = 0.33, .from = 0.1, .until = 0.7, .to = {}},
                        {.connector = 0, .along = 0.6, .from = 0.8, .until = 0.9, .to = {}}};
  made.timeline.cuts = {{.connector = 0, .along = 0.5, .time = 0.3},
                        {.connector = 0, .along = 0.8, .time = 0.8}};
  return made;
}

Simulation start(const Problem& of, const char* method, const Settings& settings) {
  return {of.world, make_method(method, settings), of.timeline};
}

TEST(SavedState, EqualStepsGoOnToTheBit) {
  const Problem made = problem();
  // What springs leave open they choose for the world at their start, which has been cut meanwhile.
  const std::pair<const char*, Settings> methods[] = {
      {"springs", {{"step", 1e-4}, {"stiffness", 1e4}}}, {"xpbd", {{"step", 1e-4}}}};
  for (const auto& [method, settings] : methods) {
    SCOPED_TRACE(method);
    Simulation whole = start(made, method, settings), first = start(made, method, settings);
    whole.advance_to(0.5);
    first.advance_to(0.5);
    Simulation second = start(made, method, settings);
    second.load(first.save());
    EXPECT_EQ(second.world().time, 0.5);
    EXPECT_EQ(state_hash(second.world()), state_hash(whole.world()));
    whole.advance_to(1);
    second.advance_to(1);
    const Snapshot one = whole.state(), other = second.state();
    ASSERT_EQ(one.connectors.size(), other.connectors.size());
    for (std::size_t c = 0; c < one.connectors.size(); ++c) {
      for (std::size_t i = 0; i < one.connectors[c].size(); ++i) {
        EXPECT_LT((one.connectors[c][i] - other.connectors[c][i]).norm(), 1e-12);
      }
      EXPECT_EQ(whole.world().connectors[c].name, second.world().connectors[c].name);
    }
  }
}

TEST(SavedState, WithoutATimelineEveryBitIsTheSame) {
  Problem made = problem();
  made.timeline = {};
  for (const char* method : {"springs", "xpbd"}) {
    SCOPED_TRACE(method);
    const Settings settings = {{"step", 1e-4}};
    Simulation whole = start(made, method, settings), first = start(made, method, settings);
    first.advance_to(0.25);
    Simulation second = start(made, method, settings);
    second.load(first.save());
    whole.advance_to(0.25);
    whole.advance_to(0.5);
    second.advance_to(0.5);
    EXPECT_EQ(state_hash(whole.world()), state_hash(second.world()));
  }
}

TEST(SavedState, DirectGoesOnWithinItsTolerance) {
  Problem made = problem();
  made.timeline.pins.clear();
  const Settings settings = {{"tolerance", 1e-6}};
  Simulation whole = start(made, "direct", settings), first = start(made, "direct", settings);
  first.advance_to(0.4);
  Simulation second = start(made, "direct", settings);
  second.load(first.save());
  whole.advance_to(0.6);
  second.advance_to(0.6);
  const Snapshot one = whole.state(), other = second.state();
  for (std::size_t c = 0; c < one.connectors.size(); ++c) {
    for (std::size_t i = 0; i < one.connectors[c].size(); ++i) {
      EXPECT_LT((one.connectors[c][i] - other.connectors[c][i]).norm(), 1e-5);
    }
  }
}

TEST(SavedState, WhatBrokeStaysSo) {
  Problem made;
  made.world = worlds::chain(5, 1, -Vec3::UnitY());
  made.world.connectors[0].breaks_at = 0.7 * worlds::kGravity;
  Simulation first = start(made, "direct", {});
  first.advance_to(0.1);
  Simulation second = start(made, "direct", {});
  second.load(first.save());
  second.advance_to(0.2);
  EXPECT_EQ(second.world().connectors.size(), 2u);
  EXPECT_EQ(second.state().connectors.size(), 2u);
}

TEST(SavedState, IsOfItsWorldAlone) {
  const Problem made = problem();
  const std::string bytes = start(made, "direct", {}).save();
  Problem other = made;
  other.world.connectors[0].position[3].y() += 1e-9;
  EXPECT_THROW(start(other, "direct", {}).load(bytes), BadState);
  other = made;
  other.timeline.cuts[0].along = 0.51;
  EXPECT_THROW(start(other, "direct", {}).load(bytes), BadState);
  other = made;
  other.world.connectors[0].breaks_at = 3;
  EXPECT_THROW(start(other, "direct", {}).load(bytes), BadState);
  EXPECT_NO_THROW(start(made, "xpbd", {}).load(bytes));  // by another method
}

/// The same with the sum of its bytes at the end.
std::string summed(std::string bytes) {
  const std::size_t before = bytes.size() - sizeof(std::uint64_t);
  const std::uint64_t sum = Hash().bytes(bytes.data(), before).value();
  std::memcpy(bytes.data() + before, &sum, sizeof sum);
  return bytes;
}

TEST(SavedState, DamageIsSaid) {
  const Problem made = problem();
  const Settings settings = {{"step", 1e-4}};
  Simulation simulation = start(made, "springs", settings);
  simulation.advance_to(0.4);
  const std::string bytes = simulation.save();
  Simulation reader = start(made, "springs", settings);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{5}, std::size_t{20}, bytes.size() - 1}) {
    EXPECT_THROW(reader.load(bytes.substr(0, size)), BadState) << size;
  }
  EXPECT_THROW(reader.load(bytes + 'x'), BadState);
  // Changed bytes whose sum is right are refused or make a world that can be stepped.
  std::mt19937 dice(1);
  int refused = 0;
  for (int i = 0; i < 600; ++i) {
    std::string changed = bytes;
    for (unsigned k = 0; k < 1 + dice() % 3; ++k) {
      changed[dice() % (changed.size() - 8)] = static_cast<char>(dice());
    }
    EXPECT_THROW(reader.load(changed), BadState);
    try {
      Simulation other = start(made, "springs", settings);
      other.load(summed(changed));
      other.advance_to(other.world().time + 1e-3);
    } catch (const BadState&) {
      ++refused;
    } catch (const std::exception&) {  // diverged, or an entry that is not possible
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_NO_THROW(reader.load(bytes));
}

}  // namespace
}  // namespace taut::saved_state_test
