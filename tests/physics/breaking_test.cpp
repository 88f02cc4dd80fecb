// Connectors that break where a tension is above Connector::breaks_at.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/run/simulation.h"
#include "sim/world/winched.h"
#include "tests/physics/worlds.h"

namespace taut::breaking_test {
namespace {

constexpr double kLength = 1, kMass = 0.2;  // m, kg
constexpr double kWeight = kMass * worlds::kGravity;

/// A weight on a light link that is released level: at an angle below, its tension is
/// 3 m g sin(angle).
World pendulum(double breaks_at) {
  World world;
  Connector cord = straight_connector("cord", kLength, 1e-9, 2, Vec3::Zero(), Vec3::UnitX());
  cord.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  cord.particle_mass[1] = kMass;
  cord.breaks_at = breaks_at;
  world.connectors = {cord};
  finish(world);
  return world;
}

Simulation run(const World& world, std::string_view method, const Settings& settings,
               double until) {
  Simulation simulation(world, make_method(method, settings));
  simulation.advance_to(until);
  return simulation;
}

TEST(Breaking, APendulumBreaksWhereItsTensionIsThat) {
  const double angle = std::numbers::pi / 6, speed = std::sqrt(2 * worlds::kGravity * kLength / 2);
  const Vec3 at(std::cos(angle), -std::sin(angle), 0);
  const Vec3 velocity = speed * Vec3(-std::sin(angle), -std::cos(angle), 0);
  for (const auto& [method, settings, close] :
       {std::tuple<const char*, Settings, double>{"direct", {{"tolerance", 1e-6}}, 3e-5},
        {"xpbd", {{"step", 2.5e-4}}, 5e-3},
        {"springs", {{"step", 2.5e-5}, {"stiffness", 1e4}}, 2e-2}}) {
    SCOPED_TRACE(method);
    const Simulation broken = run(pendulum(1.5 * kWeight), method, settings, 0.5);
    ASSERT_EQ(broken.breaks().size(), 1u);
    const Simulation::Break& found = broken.breaks()[0];
    EXPECT_EQ(found.connector, "cord");
    EXPECT_EQ(found.link, 0u);
    EXPECT_GT(found.tension, 1.5 * kWeight);
    // From there on the weight falls freely.
    const double time = 0.5 - found.cut.time;
    const Vec3 fallen = at + time * velocity + time * time / 2 * Vec3(0, -worlds::kGravity, 0);
    ASSERT_EQ(broken.world().connectors.size(), 2u);
    EXPECT_EQ(broken.world().connectors[1].name, "cord'");
    EXPECT_LT((broken.world().connectors[1].position.back() - fallen).norm(), close);
    EXPECT_EQ(broken.method().events().back().kind, Event::Kind::breaks);
  }
}

TEST(Breaking, TheBottomOfASwingHasThreeTimesTheWeight) {
  EXPECT_EQ(run(pendulum(2.999 * kWeight), "direct", {{"tolerance", 1e-6}}, 0.7).breaks().size(),
            1u);
  EXPECT_TRUE(
      run(pendulum(3.001 * kWeight), "direct", {{"tolerance", 1e-6}}, 0.7).breaks().empty());
}

// The top link of a rope has most to carry, and what is overloaded breaks at once.
TEST(Breaking, ARopeThatIsTooHeavyBreaksAtTheTop) {
  World world = worlds::chain(5, 1, -Vec3::UnitY());
  world.connectors[0].breaks_at = 0.7 * worlds::kGravity;
  const Simulation broken = run(world, "direct", {}, 0.01);
  ASSERT_EQ(broken.breaks().size(), 1u);
  EXPECT_EQ(broken.breaks()[0].link, 0u);
  EXPECT_EQ(broken.breaks()[0].cut.time, 0);
  EXPECT_NEAR(broken.breaks()[0].tension, 0.8 * worlds::kGravity, 1e-4);
  world.connectors[0].breaks_at = 0.9 * worlds::kGravity;
  EXPECT_TRUE(run(world, "direct", {}, 0.3).breaks().empty());
}

// Where nothing breaks, looks at tensions leave the bits of equal steps.
TEST(Breaking, LooksChangeNoEqualStep) {
  World world = worlds::chain(5, 1, Vec3::UnitX());
  const Simulation plain = run(world, "xpbd", {{"step", 1.0 / 960}}, 0.25);
  world.connectors[0].breaks_at = 1e6;
  const Simulation watched = run(world, "xpbd", {{"step", 1.0 / 960}}, 0.25);
  EXPECT_EQ(state_hash(plain.world()), state_hash(watched.world()));
}

// A timeline goes on with the parts, and shows them.
TEST(Breaking, ATimelineGoesOn) {
  World world = worlds::chain(9, 1, -Vec3::UnitY());
  world.connectors[0].breaks_at = 0.7 * worlds::kGravity;
  Timeline timeline;
  timeline.cuts = {{.connector = 0, .along = 0.5, .time = 0.1}};
  Simulation simulation(world, make_method("direct", {}), timeline);
  EXPECT_EQ(simulation.state().connectors.size(), 2u);
  simulation.advance_to(0.2);
  ASSERT_EQ(simulation.breaks().size(), 1u);
  EXPECT_EQ(simulation.world().connectors.size(), 3u);
  const Snapshot state = simulation.state();
  ASSERT_EQ(state.connectors.size(), 3u);
  for (const auto& part : state.connectors) EXPECT_GE(part.size(), 2u);
  EXPECT_EQ(state.connectors[0].front(), Vec3::Zero());
  EXPECT_LT(state.connectors[1].front().y(), state.connectors[0].back().y());
}

// A rope over a post that breaks there is cut at a bead: between two of them the post is in the
// way.
TEST(Breaking, OnAPostItBreaksAtABead) {
  World world;
  Obstacle& post = world.obstacles.emplace_back();
  post.name = "post";
  post.shape = sphere_shape(0.1);
  Connector rope = straight_connector("rope", 0.8, 0.08, 9, Vec3::Zero(), Vec3::UnitX());
  rope.radius = 0.01;
  for (int i = 0; i < 9; ++i) {  // links of 0.1 around the top, and down
    const double step = 2 * std::asin(0.05 / 0.111), turn = std::clamp((i - 4) * step, -1.0, 1.0);
    const double down = std::max(std::abs((i - 4) * step) - 1, 0.0) * 0.1 / step;
    rope.position[std::size_t(i)] =
        0.111 * Vec3(std::sin(turn), std::cos(turn), 0) + Vec3(0, -down, 0);
  }
  for (std::size_t k = 0; k < 8; ++k) {
    rope.rest[k] = (rope.position[k + 1] - rope.position[k]).norm();
  }
  rope.length = 0;
  for (const double rest : rope.rest) rope.length += rest;
  rope.particle_mass.front() = rope.particle_mass.back() = 1;
  rope.breaks_at = 5;
  world.connectors = {rope};
  finish(world);
  const Simulation broken = run(world, "xpbd", {{"step", 1e-3}}, 0.05);
  ASSERT_FALSE(broken.breaks().empty());
  const auto& parts = broken.world().connectors;
  std::size_t particles = 0;
  for (const Connector& part : parts) particles += part.particles();
  EXPECT_EQ(particles, 9 + parts.size() - 1);  // each cut doubles one
}

TEST(Breaking, NeedsAConnectorThatKeepsItsLength) {
  World world = worlds::chain(5, 1, -Vec3::UnitY());
  std::vector<PathKey> keys(2);
  keys[1].time = 1;
  keys[1].position.x() = 0.1;
  add_winches(world, world.connectors[0], std::make_shared<const Path>(keys), nullptr);
  world.connectors[0].breaks_at = 1;
  EXPECT_THROW(finish(world), std::invalid_argument);
}

}  // namespace
}  // namespace taut::breaking_test
