// taut check: what it says of scenes.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut::check_test {
namespace {

namespace fs = std::filesystem;

TEST(Check, SaysWhatItWouldDo) {
  const Folder folder;
  folder.write("scene.toml", kPushedStick);
  const ProgramResult outcome = run_taut({"check", "scene.toml", "--json"}, folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("frames"), 5);
  EXPECT_EQ(json.at("steps_per_frame"), 20);
  EXPECT_EQ(json.at("bodies").at("free").at("driven"), false);
  EXPECT_EQ(json.at("bodies").at("held").at("driven"), true);
  EXPECT_GT(json.at("simulate").at("memory_bytes"), 0);
  EXPECT_EQ(json.at("stage"), false);
  EXPECT_EQ(json.at("clip_frames"), 5) << "taut's own stage";
  EXPECT_EQ(json.at("warnings").size(), 0u);
}

// Of the cords of a net, and of copies side by side, one line.
TEST(Check, SaysWhatANetIs) {
  const ProgramResult ladder =
      run_taut({"check", TAUT_SOURCE_DIR "/scenes/topology/rope_ladder.toml"});
  ASSERT_EQ(ladder.code, 0) << ladder.messages;
  EXPECT_NE(ladder.output.find("net ladder: 15 cords of 0.28 to 1.8 m, 2 kg, 148 particles, "
                               "26 joints, 2 held\n"),
            std::string::npos)
      << ladder.output;
  EXPECT_EQ(ladder.output.find("connector ladder"), std::string::npos) << ladder.output;
  const ProgramResult curtain = run_taut({"check", TAUT_SOURCE_DIR "/scenes/bead_curtain.toml"});
  ASSERT_EQ(curtain.code, 0) << curtain.messages;
  EXPECT_NE(curtain.output.find("connectors cord to cord#1000: each 1.5 m, 0.03 kg, 31 particles"),
            std::string::npos)
      << curtain.output;
}

TEST(Check, EveryShippedSceneIsGood) {
  for (const auto& entry : fs::recursive_directory_iterator(TAUT_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const ProgramResult outcome = run_taut({"check", entry.path().string()});
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
  }
}

TEST(Check, SchemaIsTheOneThatIsShipped) {
  const ProgramResult outcome = run_taut({"check", "--schema"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(outcome.output == read_file(TAUT_SOURCE_DIR "/scenes/scene.schema.json"))
      << "the format or a method changed; run: taut check --schema > scenes/scene.schema.json";
}

}  // namespace
}  // namespace taut::check_test
