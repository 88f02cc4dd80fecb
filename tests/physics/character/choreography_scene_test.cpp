// The routines of scenes/choreography, whose hands were found from where the tip is to be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/load/load_scene.h"
#include "sim/choreography/choreography.h"
#include "sim/choreography/flat_fit.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"

namespace taut::choreography_scene_test {
namespace {

constexpr const char* kScene = TAUT_SOURCE_DIR "/scenes/choreography/turning_eight.toml";
constexpr const char* kSpin = TAUT_SOURCE_DIR "/scenes/nunchaku.toml";

void expect_as_asked(const char* file) {
  const scenes::Scene scene = scenes::load_scene(file, false);
  const scenes::Choreographed asked = scenes::load_choreography(file).value();
  const std::vector<PathKey> keys =
      choreography::hand_path(scene.world, asked.problem.body)->keys();
  const std::vector<double> misses = choreography::misses(asked.problem, scene.world, 1e-4);
  EXPECT_LT(*std::ranges::max_element(misses), asked.within);
  const choreography::HandMotion hand = choreography::motion_of_hand(asked.problem, keys);
  EXPECT_LT(hand.reach, asked.problem.limits.reach);
  EXPECT_LT(hand.speed, asked.problem.limits.speed);
  EXPECT_LT(hand.acceleration, asked.problem.limits.acceleration);
}

TEST(LongChoreographyScene, TheTipPassesItsPointsAndTheHandKeepsToItsLimits) {
  for (const char* file : {kScene, kSpin}) {
    SCOPED_TRACE(file);
    expect_as_asked(file);
  }
}

/// The tip goes round above the hand five times, and all hangs still after it.
TEST(LongChoreographyScene, TheSpinStandsUprightAndComesToRest) {
  const scenes::Scene scene = scenes::load_scene(kSpin, false);
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-4}}));
  double turned = 0, before = 0;
  for (int k = 0; k <= 260; ++k) {
    simulation.advance_to(7.0 + 0.01 * k);
    const Vec3 tip = simulation.state().bodies.at(1).to_world(Vec3(0, -0.15, 0));
    const Vec3 out = tip - Vec3(-0.22, 1.13, 0.62);
    const double angle = std::atan2(out.y(), out.x());
    if (k > 0) turned += std::remainder(angle - before, 2 * std::numbers::pi);
    before = angle;
  }
  EXPECT_NEAR(turned, 5 * 2 * std::numbers::pi, 0.01);  // 2 mm at either end, of 0.56 m
  simulation.advance_to(11.8);                          // s: then it is thrown
  EXPECT_LT(simulation.world().bodies.at(1).velocity.norm(), 0.05);
}

/// The scene's own run, without the choreography's functions.
TEST(LongChoreographyScene, TheTipIsInTheMiddleOfTheEightAfterEachLapAndRestsAtTheEnd) {
  const scenes::Scene scene = scenes::load_scene(kScene, false);
  Simulation simulation = scenes::start(scene);
  for (int lap = 0; lap <= 4; ++lap) {
    simulation.advance_to(1.2 + 1.6 * lap);
    const Vec3 tip = simulation.state().bodies.at(1).to_world(Vec3(0, -0.15, 0));
    EXPECT_LT((tip - Vec3(-0.22, 0.82, 0.60)).norm(), 0.002) << lap;
  }
  simulation.advance_to(scene.duration);
  EXPECT_LT(simulation.world().bodies.at(1).velocity.norm(), 0.05);
}

}  // namespace
}  // namespace taut::choreography_scene_test
