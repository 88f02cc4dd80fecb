// Values read in place of a scene file's own, and the start that they can give.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"

namespace taut::scene_change_test {
namespace {

const std::filesystem::path kSwing = TAUT_SOURCE_DIR "/scenes/rope_swing.toml";

scenes::Scene changed(const std::vector<scenes::SceneChange>& changes) {
  return scenes::load_scene(kSwing, false, changes);
}

TEST(SceneChange, TakesThePlaceOfTheFilesValue) {
  const scenes::Scene scene = changed({{"connectors.rope.particles", "41"},
                                       {"connectors.rope.start", "{ direction = [0, 1, 0] }"},
                                       {"gravity", "[0, -1.6, 0]"}});
  const Connector& rope = scene.world.connectors.at(0);
  EXPECT_EQ(rope.particles(), 41u);
  EXPECT_NEAR((rope.position.back() - Vec3(0, 0.8, 0)).norm(), 0, 1e-15);
  EXPECT_EQ(scene.world.gravity, Vec3(0, -1.6, 0));
  EXPECT_EQ(scenes::load_scene(kSwing, false).world.connectors[0].particles(), 21u);
}

TEST(SceneChange, IsCheckedLikeTheFile) {
  for (const scenes::SceneChange& wrong :
       std::vector<scenes::SceneChange>{{"connectors.rope.particles", "1"},
                                        {"connectors.rope.particles", "x y"},
                                        {"connectors.rope.length.unit", "1"},
                                        {"connectors.rope.colour", "1"},
                                        {"duration", "nan"}}) {
    try {
      changed({wrong});
      ADD_FAILURE() << wrong.key << " = " << wrong.value << " was taken";
    } catch (const scenes::BadScene& error) {
      const std::string key = wrong.key.substr(0, wrong.key.find_last_of('.'));
      EXPECT_NE(std::string(error.what()).find(key), std::string::npos) << error.what();
    }
  }
}

TEST(SceneChange, SpinTurnsTheConnectorAsOnePiece) {
  const scenes::Scene scene =
      changed({{"connectors.rope.start", "{ direction = [1, 0, 0], spin = [0, 0, 3] }"}});
  const Connector& rope = scene.world.connectors.at(0);
  EXPECT_NEAR((rope.velocity.back() - Vec3(0, 0.6, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((rope.velocity[10] - Vec3(0, 0.3, 0)).norm(), 0, 1e-15);
  EXPECT_THROW(changed({{"connectors.rope.start", "{ direction = [1, 0, 0], spin = [0, 0, 3] }"},
                        {"connectors.rope.to", "{ fixed = [0.2, 0.6, 0] }"}}),
               scenes::BadScene);
}

// Links that end exactly on the corners of a line, but for rounding.
TEST(SceneStart, PointsKeepCornersThatLinksReach) {
  const scenes::Scene scene =
      scenes::load_scene(TAUT_SOURCE_DIR "/scenes/hard/taut_snap.toml", false);
  const Connector& cord = scene.world.connectors.at(0);
  EXPECT_NEAR((cord.position[9] - Vec3(-0.05, 0.55, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((cord.position[11] - Vec3(0.05, 0.55, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((cord.position[20] - Vec3(0.05, 1, 0)).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace taut::scene_change_test
