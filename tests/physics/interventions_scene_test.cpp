// The scenes whose connectors are pinned and cut, against known answers.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scenes/load/load_scene.h"
#include "sim/measure/measure.h"
#include "worlds.h"

namespace taut::interventions_scene_test {
namespace {

scenes::Scene scene(const char* name) {
  return scenes::load_scene(std::string(TAUT_SOURCE_DIR "/scenes/") + name, false);
}

// A particle that is added for a pin has no mass: no bound on a step comes of it.
TEST(PinnedRope, IsFollowedByEveryMethodAsItIs) {
  const World rope = worlds::chain(9, 0.5, worlds::from_down(60));
  Timeline timeline;
  timeline.pins = {{0, 0.27, 0.1, 0.2, {}}};
  Simulation truth(rope, make_method("truth", {}), timeline);
  truth.advance_to(0.3);
  for (const MethodInfo& method : all_methods()) {
    if (method.name == "sdfast") continue;  // follows no pinned chain
    Simulation simulation(rope, make_method(method.name, {}), timeline);
    simulation.advance_to(0.3);
    for (std::size_t i = 0; i < 9; ++i) {
      const Vec3 apart = simulation.state().connectors[0][i] - truth.state().connectors[0][i];
      EXPECT_LT(apart.norm(), 0.1 * 0.5) << method.name;  // of the half metre that it goes
    }
  }
}

// Caught in its middle, the rope's lower half and the object swing as one stiff pendulum about the
// pin: the rope is light, and stays straight but for some thousandths.
TEST(PinScene, TheCaughtRopeSwingsWithThePeriodOfTheShorterPendulum) {
  const scenes::Scene pin = scene("pin.toml");
  Simulation simulation = scenes::start(pin);
  const TimedPin& caught = pin.timeline.pins.at(0);
  simulation.advance_to(caught.from);
  const Vec3 place = caught.to->point, met = simulation.world().connectors[0].position[12];
  EXPECT_LT((met - place).norm(), 2e-3);
  const auto angle = [&] {
    const Vec3 down = simulation.world().bodies[0].position - place;
    return std::atan2(down.x(), -down.y());
  };
  double largest = 0, before = angle();
  std::vector<double> crossings;     // s, of straight down
  constexpr double sampling = 1e-3;  // s
  for (int k = 1; caught.from + sampling * k < caught.until; ++k) {
    simulation.advance_to(caught.from + sampling * k);
    const double now = angle();
    if (before * now < 0) {
      crossings.push_back(simulation.world().time - sampling * now / (now - before));
    }
    largest = std::max(largest, std::abs(now));
    before = now;
    if (simulation.world().time < caught.from + caught.over) continue;
    EXPECT_EQ(simulation.world().connectors[0].position[12], place);
  }
  ASSERT_GE(crossings.size(), 3u);
  const std::size_t swings = crossings.size() - 1;
  const double period = 2 * (crossings.back() - crossings.front()) / static_cast<double>(swings);

  const Body& bob = simulation.world().bodies[0];
  const double rope = pin.world.connectors[0].mass / 2, length = caught.along;
  const double mass = bob.bare.mass, far = length + 0.04;  // m, to the object's centre
  const double inertia = mass * far * far + bob.bare.inertia(0, 0) + rope * length * length / 3;
  const double moment = worlds::kGravity * (mass * far + rope * length / 2);
  const double expected = 2 * std::numbers::pi * std::sqrt(inertia / moment) *
                          worlds::period_ratio(largest * 180 / std::numbers::pi);
  EXPECT_NEAR(period / expected, 1, 5e-3);
  EXPECT_LT(period, 1.6);  // the whole rope's is 2.0 s

  simulation.advance_to(pin.duration);
  EXPECT_EQ(simulation.world().connectors[0].holds.size(), 2u);
  EXPECT_GT((simulation.world().connectors[0].position[12] - place).norm(), 0.05);
  EXPECT_LT(stretch_max(simulation.world()), 1e-9);
}

// Without gravity, what has been let go keeps its momentum, and so does each part of what is cut.
TEST(HoseScene, WhatIsReleasedAndCutKeepsItsMomentum) {
  const scenes::Scene hose = scene("hose.toml");
  Simulation simulation = scenes::start(hose);
  const World& world = simulation.world();
  const TimedPin& pull = hose.timeline.pins.at(0);
  const TimedCut& cut = hose.timeline.cuts.at(0);
  simulation.advance_to(pull.until);
  const Vec3 pulled = linear_momentum(world);
  EXPECT_GT(pulled.y(), 0.1);
  EXPECT_EQ(world.connectors[0].holds.size(), 2u);

  // A body and the particles of its part of the hose.
  const auto part = [&](std::size_t index) {
    World alone = world;
    alone.connectors = {world.connectors[index]};
    Vec3 momentum = linear_momentum(alone);
    const Body& other = world.bodies[1 - index];
    return Vec3(momentum - other.mass_properties.mass * other.velocity);
  };
  simulation.advance_to(cut.time);
  ASSERT_EQ(world.connectors.size(), 2u);
  EXPECT_LT((linear_momentum(world) - pulled).norm(), 1e-4 * pulled.norm());
  EXPECT_NEAR(world.connectors[0].length, cut.along, 1e-12);
  const Vec3 left = part(0), right = part(1);
  simulation.advance_to(hose.duration);
  EXPECT_LT((part(0) - left).norm(), 1e-4 * pulled.norm());
  EXPECT_LT((part(1) - right).norm(), 1e-4 * pulled.norm());
  EXPECT_GT((world.connectors[0].position.back() - world.connectors[1].position.front()).norm(),
            0.1);
}

}  // namespace
}  // namespace taut::interventions_scene_test
