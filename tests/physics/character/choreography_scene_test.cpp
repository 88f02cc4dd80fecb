// The routine of scenes/choreography, whose hand was found from the tip's points.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/load/load_scene.h"

namespace taut::choreography_scene_test {
namespace {

constexpr const char* kScene = TAUT_SOURCE_DIR "/scenes/choreography/turning_eight.toml";

TEST(ChoreographyScene, TheTipIsWithinFiveMillimetresOfTheTurningEight) {
  const scenes::Scene scene = scenes::load_scene(kScene, false);
  ASSERT_EQ(scene.method.name, "direct");
  const Vec3 end = scene.world.connectors.at(0).position.front();
  Simulation simulation = scenes::start(scene);
  double worst = 0;
  for (int k = 0; k <= 32; ++k) {
    const double along = std::numbers::pi / 4 * k;
    const double turn = std::numbers::pi / 4 * std::clamp((k - 8) / 16.0, 0.0, 1.0);
    const double wide = 0.4 * std::sin(along), high = -0.27 - 0.15 * std::cos(2 * along);
    simulation.advance_to(1.2 + 0.2 * k);
    const Vec3 tip = simulation.state().bodies.at(1).to_world(Vec3(0, -0.15, 0));
    const Vec3 at = end + Vec3(wide * std::cos(turn), high, wide * std::sin(turn));
    worst = std::max(worst, (tip - at).norm());
  }
  EXPECT_LT(worst, 0.005);
}

TEST(ChoreographyScene, TheHandKeepsToItsLimitsAndRestsAtTheEnd) {
  const scenes::Scene scene = scenes::load_scene(kScene, false);
  const std::shared_ptr<const Path> hand = scene.world.bodies.at(0).path;
  double speed = 0, acceleration = 0, reach = 0;
  for (double time = 0; time < scene.duration; time += 1e-3) {
    const FrameMotion motion = hand->at(time);
    speed = std::max(speed, motion.velocity.norm());
    acceleration = std::max(acceleration, motion.acceleration.norm());
    reach = std::max(reach, (motion.position - Vec3(-0.2, 1.4, 0)).norm());
  }
  EXPECT_LT(speed, 2);
  EXPECT_LT(acceleration, 20);
  EXPECT_LT(reach, 0.7);
  Simulation simulation = scenes::start(scene);
  simulation.advance_to(scene.duration);
  EXPECT_LT(simulation.world().bodies.at(1).velocity.norm(), 0.05);
}

}  // namespace
}  // namespace taut::choreography_scene_test
