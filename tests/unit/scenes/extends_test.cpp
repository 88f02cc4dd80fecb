// A scene that says what is different from another.
#include <gtest/gtest.h>

#include <string>

#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "tests/support/folder.h"

namespace taut::extends_test {
namespace {

class Extends : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("base.toml", read_file(TAUT_SOURCE_DIR "/scenes/rope_swing.toml"));
  }
  scenes::Scene scene(const std::string& text) {
    return scenes::load_scene(folder_.write("scene.toml", text), false);
  }
  std::string error(const std::string& text) {
    try {
      scene(text);
    } catch (const scenes::BadScene& bad) {
      return bad.what();
    }
    return "none";
  }
  Folder folder_;
};

TEST_F(Extends, TakesWhatItDoesNotSay) {
  const scenes::Scene base = scenes::load_scene(folder_.path() / "base.toml", false);
  const scenes::Scene both = scene(
      "extends = \"base.toml\"\n"
      "[method]\nname = \"direct\"\ntolerance = 1e-6\n");
  EXPECT_EQ(both.title, base.title);
  EXPECT_EQ(both.world.connectors.at(0).position, base.world.connectors.at(0).position);
  EXPECT_EQ(both.method.name, "direct");
  EXPECT_EQ(both.method.settings.size(), 1u);  // none of the base's method
}

TEST_F(Extends, NamesTheFileThatIsWrong) {
  const std::string none = error("extends = \"none.toml\"\n");
  EXPECT_NE(none.find("scene.toml:1:11: extends: "), std::string::npos) << none;
  EXPECT_NE(none.find("none.toml: cannot be opened: No such file"), std::string::npos) << none;
  std::filesystem::create_directory(folder_.path() / "folder");
  const std::string folder = error("extends = \"folder\"\n");
  EXPECT_NE(folder.find("scene.toml:1:11: extends: "), std::string::npos) << folder;
  EXPECT_NE(folder.find("folder: is a directory, expected a scene file"), std::string::npos);
  EXPECT_NE(error("extends = \"../base.toml\"\n")
                .find("scene.toml:1:11: extends: found \"../base.toml\", expected the name of"),
            std::string::npos);
  EXPECT_NE(error("extends = 5\n").find("scene.toml:1:11: extends: found 5"), std::string::npos);
  EXPECT_NE(error("extends = \"scene.toml\"\n").find("scene.toml:1:11: extends: "),
            std::string::npos);
  folder_.write("base.toml", "duration = -1\n");
  const std::string inherited = error("extends = \"base.toml\"\n");
  EXPECT_NE(inherited.find("base.toml:1:12: duration: found -1"), std::string::npos) << inherited;
}

}  // namespace
}  // namespace taut::extends_test
