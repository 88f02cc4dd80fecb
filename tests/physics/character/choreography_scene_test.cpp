// The routine of scenes/choreography, whose hand was found from where the tip is to be.
#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/load/load_scene.h"
#include "sim/choreography/choreography.h"
#include "sim/choreography/hand_frame.h"

namespace taut::choreography_scene_test {
namespace {

constexpr const char* kScene = TAUT_SOURCE_DIR "/scenes/choreography/turning_eight.toml";

TEST(ChoreographyScene, TheTipPassesItsPointsAndTheHandKeepsToItsLimits) {
  const scenes::Scene scene = scenes::load_scene(kScene, false);
  const scenes::Choreographed asked = scenes::load_choreography(kScene).value();
  const std::vector<PathKey> keys =
      choreography::hand_path(scene.world, asked.problem.body)->keys();
  const std::vector<double> misses = choreography::misses(asked.problem, scene.world, 1e-4);
  EXPECT_LT(*std::ranges::max_element(misses), asked.within);
  const choreography::HandMotion hand = choreography::motion_of_hand(asked.problem, keys);
  EXPECT_LT(hand.reach, asked.problem.limits.reach);
  EXPECT_LT(hand.speed, asked.problem.limits.speed);
  EXPECT_LT(hand.acceleration, asked.problem.limits.acceleration);
}

/// The scene's own run, without the choreography's functions.
TEST(ChoreographyScene, TheTipIsInTheMiddleOfTheEightAfterEachLapAndRestsAtTheEnd) {
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
