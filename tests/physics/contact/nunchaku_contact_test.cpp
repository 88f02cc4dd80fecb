// The free stick of a nunchaku meets the arm, the held stick and its own chain.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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

/// The gap (m) between the stick and the nearest bead of its chain.
double gap_of_chain(const World& world) {
  const Body& body = world.bodies[1];
  const contact::Capsule own{body.point(body.capsule.from), body.point(body.capsule.to),
                             body.capsule.radius};
  const Connector& chain = world.connectors.front();
  double least = INFINITY;
  for (std::size_t i = 1; i + 1 < chain.particles(); ++i) {
    const Vec3& at = chain.position[i];
    least = std::min(least, contact::least_gap(own, {at, at, chain.radius}));
  }
  return least;
}

TEST(LongNunchakuContact, NothingPassesThroughTheArm) {
  const scenes::Scene scene = shipped();
  Simulation simulation(scene.world, make_method(scene.method.name, scene.method.settings));
  std::map<std::string, double> least;
  double least_of_chain = INFINITY;
  for (int frame = 1; frame <= scene.frames(); ++frame) {
    simulation.advance_to(frame / double(scene.fps));
    const double chain = gap_of_chain(simulation.world());
    EXPECT_GT(chain, -kInside) << "frame " << frame;
    least_of_chain = std::min(least_of_chain, chain);
    for (const Obstacle& obstacle : scene.world.obstacles) {
      const double apart = gap_to(obstacle, stick(simulation), simulation.world().time);
      const auto found = least.emplace(obstacle.name, apart).first;
      found->second = std::min(found->second, apart);
      EXPECT_GT(apart, -kInside) << obstacle.name << " in frame " << frame;
    }
  }
  EXPECT_LT(least.at("forearm"), kInside);
  EXPECT_LT(least.at("stick"), kInside);
  EXPECT_LT(least_of_chain, kInside);
}

TEST(NunchakuContact, AgreesWithTheTruthUntilTheStickTurnsOver) {
  scenes::Scene scene = shipped();
  scene.world.bead_pairs.clear();  // no bead has come to the stick until then
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", kTolerance}}));
  Simulation truth(scene.world, make_method("truth", {}));
  for (int frame = 1; frame <= int(kTurnsOver * scene.fps); ++frame) {
    for (Simulation* one : {&simulation, &truth}) one->advance_to(frame / double(scene.fps));
    EXPECT_LT((stick(simulation).position - stick(truth).position).norm(), kTolerance) << frame;
    EXPECT_GT(gap_of_chain(truth.world()), 0) << frame;
  }
}

}  // namespace
}  // namespace taut::nunchaku_contact_test
