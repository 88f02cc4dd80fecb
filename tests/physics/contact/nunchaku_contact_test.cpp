// The free stick of a nunchaku meets the arm and the held stick.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "scenes/load/load_scene.h"
#include "sim/contact/capsule.h"
#include "sim/run/simulation.h"

namespace taut::nunchaku_contact_test {
namespace {

constexpr double kTolerance = 1e-4;  // m
constexpr double kTurnsOver = 1.6;   // s: from then on a nudge grows a hundredfold until it lands
constexpr double kInside = 1e-9;     // m

scenes::Scene shipped() {
  return scenes::load_scene(TAUT_SOURCE_DIR "/scenes/contact/nunchaku_catch.toml", false);
}

const Body& stick(const Simulation& simulation) {
  return simulation.world().bodies[1];
}

/// The gap (m) between the stick and the obstacle.
double gap_to(const Obstacle& obstacle, const Body& body, double time) {
  const contact::Capsule own{body.point(body.capsule.from), body.point(body.capsule.to),
                             body.capsule.radius};
  return contact::least_gap(obstacle.shape, obstacle.frame(time).pose(), own);
}

TEST(NunchakuContact, NothingPassesThroughTheArm) {
  const scenes::Scene scene = shipped();
  Simulation simulation(scene.world, make_method(scene.method.name, scene.method.settings));
  std::map<std::string, double> least;
  for (int frame = 1; frame <= scene.frames(); ++frame) {
    simulation.advance_to(frame / double(scene.fps));
    for (const Obstacle& obstacle : scene.world.obstacles) {
      const double apart = gap_to(obstacle, stick(simulation), simulation.world().time);
      const auto found = least.emplace(obstacle.name, apart).first;
      found->second = std::min(found->second, apart);
      EXPECT_GT(apart, -kInside) << obstacle.name << " in frame " << frame;
    }
  }
  EXPECT_LT(least.at("forearm"), kInside);
  EXPECT_LT(least.at("stick"), kInside);
}

TEST(NunchakuContact, AgreesWithTheTruthUntilTheStickTurnsOver) {
  const scenes::Scene scene = shipped();
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", kTolerance}}));
  Simulation truth(scene.world, make_method("truth", {}));
  for (int frame = 1; frame <= int(kTurnsOver * scene.fps); ++frame) {
    for (Simulation* one : {&simulation, &truth}) one->advance_to(frame / double(scene.fps));
    EXPECT_LT((stick(simulation).position - stick(truth).position).norm(), kTolerance) << frame;
  }
}

}  // namespace
}  // namespace taut::nunchaku_contact_test
