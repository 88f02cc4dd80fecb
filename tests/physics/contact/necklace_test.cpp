// scenes/contact/necklace.toml: a chain that a character wears.
#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/load/load_scene.h"
#include "sim/contact/capsule.h"
#include "sim/measure/measure.h"
#include "sim/run/simulation.h"

namespace taut::necklace_test {
namespace {

// It never enters the body, its strings stay as long as they are but for a hundredth, and three
// seconds after the hand has come to rest it sways by less than a tenth of how it was flung, held
// up by the chest it lies on.
TEST(Necklace, IsFlungAndComesToLieOnTheChest) {
  const scenes::Scene scene =
      scenes::load_scene(TAUT_SOURCE_DIR "/scenes/contact/necklace.toml", false);
  Simulation simulation(scene.world, make_method(scene.method.name, scene.method.settings));
  double fastest = 0;
  const auto speed = [&] {
    double most = 0;
    for (const Vec3& velocity : simulation.world().connectors[0].velocity) {
      most = std::max(most, velocity.norm());
    }
    return most;
  };
  for (int tenth = 1; tenth <= 60; ++tenth) {
    simulation.advance_to(tenth / 10.0);
    EXPECT_LE(contact::penetration_max(simulation.world()), 1e-9) << tenth;
    EXPECT_LT(stretch_max(simulation.world()), 0.01) << tenth;
    fastest = std::max(fastest, speed());
  }
  EXPECT_GT(fastest, 0.5);
  EXPECT_LT(speed(), fastest / 10);
  // A chain that hangs freely between its ends is a catenary, deeper than where the chest lets it.
  const Connector& chain = simulation.world().connectors[0];
  double foremost = 0, ends = 0;
  for (const Vec3& at : chain.position) foremost = std::max(foremost, at.z());
  ends = std::max(chain.position.front().z(), chain.position.back().z());
  EXPECT_GT(foremost, ends + 0.1);
}

}  // namespace
}  // namespace taut::necklace_test
