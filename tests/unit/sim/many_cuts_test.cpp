// Cuts by the thousand: each costs what it touches.
#include <gtest/gtest.h>

#include "sim/interventions/interventions.h"

namespace taut {
namespace {

Connector straight(const Vec3& start) {
  Connector rope = straight_connector("rope", 1, 0.2, 11, start, Vec3(1, -1, 0));
  for (std::size_t i = 0; i < rope.particles(); ++i) rope.velocity[i] = Vec3(0, 0, double(i));
  return rope;
}

/// One rope, held at its first particle.
World rope() {
  World world;
  world.connectors = {straight(Vec3::Zero())};
  world.connectors[0].holds = {{0, {}}};
  finish(world);
  return world;
}

TEST(ManyCuts, AtOnceAreThoseOneAfterTheOther) {
  World single = rope();
  Interventions one_by_one, at_once;
  ASSERT_EQ(one_by_one.pin(single, 0, 0.33).outcome, Outcome::done);
  World world = single;
  const std::vector<double> along{0.7, 0.04, 0.58, 0.92, 0.4, 0.26};
  std::vector<double> starts{0};  // of the parts
  for (const double place : along) {
    std::size_t part = 0;
    for (std::size_t k = 1; k < starts.size(); ++k) {
      if (starts[k] < place && starts[k] > starts[part]) part = k;
    }
    ASSERT_EQ(one_by_one.cut(single, part, place - starts[part]).outcome, Outcome::done);
    starts.push_back(place);
  }
  ASSERT_TRUE(at_once.cut(world, 0, along));
  EXPECT_EQ(world.topology, structure(world));
  ASSERT_EQ(world.connectors.size(), 7u);
  for (std::size_t c = 0; c < 7; ++c) {
    const Connector &a = single.connectors[c], &b = world.connectors[c];
    EXPECT_EQ(a.name, b.name);
    EXPECT_NEAR(a.length, b.length, 1e-15);
    EXPECT_NEAR(a.mass, b.mass, 1e-16);
    ASSERT_EQ(a.particles(), b.particles());
    EXPECT_EQ(a.holds.size(), b.holds.size());
    for (std::size_t i = 0; i < a.particles(); ++i) {
      EXPECT_LT((a.position[i] - b.position[i]).norm(), 1e-15);
      EXPECT_NEAR(a.particle_mass[i], b.particle_mass[i], 1e-16);
    }
  }
  // Cuts that would be refused one after the other change nothing together.
  World before = rope();
  const std::uint64_t topology = before.topology;
  Interventions refused;
  EXPECT_FALSE(refused.cut(before, 0, std::vector{0.5, 0.5}));
  EXPECT_FALSE(refused.cut(before, 0, std::vector{0.5, 1.0}));
  EXPECT_EQ(before.connectors.size(), 1u);
  EXPECT_EQ(before.topology, topology);
}

/// Two pairs of ropes, each joined in their middles.
World pairs() {
  World world;
  for (const double side : {0.0, 0.0, 2.0, 2.0}) world.connectors.push_back(straight({0, 0, side}));
  world.joints = {{{{0, 5}, {1, 5}}}, {{{2, 5}, {3, 5}}}};
  finish(world);
  return world;
}

TEST(ManyCuts, LookAtNoJointsOfOtherConnectors) {
  World world = pairs(), other = world;
  other.joints[1].particles[0].particle = 6;  // by hand, and nobody has taken the topology anew
  Interventions interventions, same;
  const std::uint64_t before = world.topology;
  ASSERT_EQ(interventions.cut(world, 0, 0.23).outcome, Outcome::done);
  ASSERT_EQ(same.cut(other, 0, 0.23).outcome, Outcome::done);
  EXPECT_NE(world.topology, before);
  EXPECT_EQ(world.topology, structure(world));
  EXPECT_EQ(other.topology, world.topology);
}

}  // namespace
}  // namespace taut
