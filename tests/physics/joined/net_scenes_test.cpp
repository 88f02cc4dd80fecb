// Scenes of nets against what is known of them.
#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/load/load_scene.h"
#include "sim/measure/measure.h"
#include "sim/run/simulation.h"

namespace taut::net_scenes_test {
namespace {

scenes::Scene shipped(const std::string& name, const std::vector<scenes::SceneChange>& changes) {
  return scenes::load_scene(TAUT_SOURCE_DIR "/scenes/" + name + ".toml", false, changes);
}

/// The most by which energy changes over the scene, as a share of its scale; links keep their
/// lengths.
double energy_change(const scenes::Scene& scene, double tolerance) {
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", tolerance}}));
  const double first = energy(scene.world), scale = energy_scale(scene.world);
  double most = 0;
  for (double time = 0.1; time < scene.duration; time += 0.1) {
    simulation.advance_to(time);
    most = std::max(most, std::abs(energy(simulation.world()) - first) / scale);
    EXPECT_LT(stretch_max(simulation.world()), 1e-9) << time;
  }
  return most;
}

// Nothing takes energy from what swings: an error of places of the tolerance is one of energy by
// its share of the length.
TEST(RopeLadder, KeepsItsEnergy) {
  EXPECT_LT(energy_change(shipped("topology/rope_ladder", {}), 1e-3), 1e-3 / 1.8);
}

// Its own motion for a net of a tenth of the knots along each side.
TEST(Net, KeepsItsEnergy) {
  EXPECT_LT(energy_change(shipped("topology/net", {{"nets.net.cells", "[16, 16]"}}), 1e-3),
            1e-3 / 1.6);
}

// Straight down it stays where it is.
TEST(RopeLadder, HangsAtRest) {
  const scenes::Scene scene = shipped("topology/rope_ladder", {{"nets.ladder.down", "[0, -1, 0]"}});
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-6}}));
  simulation.advance_to(2);
  const World& world = simulation.world();
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (std::size_t i = 0; i < world.connectors[c].particles(); ++i) {
      const Vec3 moved = world.connectors[c].position[i] - scene.world.connectors[c].position[i];
      EXPECT_LT(moved.norm(), 1e-9);
    }
  }
}

// The ball falls freely to the net, which throws it up again to less than where it was; nothing
// gives it energy meanwhile. A net of a quarter of the knots along each side, of cords four
// times as stiff.
TEST(BallInNet, IsThrownUpAgain) {
  const scenes::Scene scene = shipped("contact/ball_in_net", {{"nets.net.cells", "[24, 24]"},
                                                              {"nets.net.axial_stiffness", "160"},
                                                              {"nets.net.axial_damping", "0.008"}});
  Simulation simulation(scene.world, make_method("springs", {}));
  const double start = scene.world.bodies[0].position.y(), scale = energy_scale(scene.world);
  double before = energy(scene.world), lowest = start, highest = 0;
  for (int frame = 1; frame <= 180; ++frame) {
    const double time = frame / 60.0;
    simulation.advance_to(time);
    const double height = simulation.world().bodies[0].position.y();
    if (height > 1.4 && lowest > 1.4) {
      EXPECT_NEAR(height, start - 9.81 * time * time / 2, 1e-3);
    }
    lowest = std::min(lowest, height);
    if (lowest < 1) highest = std::max(highest, height);
    const double now = energy(simulation.world());
    EXPECT_LT(now - before, 1e-3 * scale) << frame;
    before = now;
  }
  EXPECT_LT(lowest, 0.9);
  EXPECT_GT(lowest, 0.2);
  EXPECT_GT(highest, 1.2);
  EXPECT_LT(highest, start);
}

}  // namespace
}  // namespace taut::net_scenes_test
