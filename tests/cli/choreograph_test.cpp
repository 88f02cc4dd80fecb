// taut choreograph: what it writes, and when it writes nothing.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/folder.h"
#include "tests/support/json_schema.h"
#include "tests/support/program.h"

namespace taut::choreograph_test {
namespace {

constexpr const char* kScene =
    "duration = 4.0\nmethod = { name = \"direct\" }\n[paths.hand]\n"
    "keys = [{ t = 0.0, position = [0, 2, 0] }]\n[bodies.free]\nmass = 0.1\n"
    "shape = { cylinder = { length = 0.3, diameter = 0.03 } }\nhangs = [0, -1, 0]\n"
    "[connectors.chain]\nlength = 0.1\nmass = 0.01\nparticles = 5\nfrom = { path = \"hand\" }\n"
    "to = { body = \"free\", point = [0, 0.15, 0] }\n[choreography]\nbody = \"free\"\n"
    "path = \"hand\"\nfile = \"hand.csv\"\nuntil = 3.0\npoint = [0, -0.15, 0]\n"
    "waypoints = [{ t = 1.0, position = [0.2, 1.7, 0] }, { t = 2.0, position = [-0.1, 1.7, 0] }]\n";

TEST(Choreograph, WritesAPathThatAllCommandsKnow) {
  Folder folder;
  folder.write("scene.toml", kScene);
  EXPECT_EQ(run_taut({"simulate", "scene.toml"}, folder.path()).code, 3);
  const ProgramResult outcome = run_taut({"choreograph", "scene.toml", "--json"}, folder.path());
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto told = nlohmann::json::parse(outcome.output);
  const JsonSchema schema(
      nlohmann::json::parse(read_file(TAUT_SOURCE_DIR "/render/cli/results.schema.json")));
  EXPECT_EQ(schema.complaint(told, "choreograph"), "");
  EXPECT_LE(told.at("worst_m").get<double>(), 0.002);
  EXPECT_EQ(told.at("waypoints").size(), 2u);
  EXPECT_EQ(run_taut({"simulate", "scene.toml"}, folder.path()).code, 0);
  // The path as it stands is the one that was certified, to the last digit.
  const ProgramResult again =
      run_taut({"choreograph", "scene.toml", "--as-it-stands", "--json"}, folder.path());
  EXPECT_EQ(nlohmann::json::parse(again.output).at("worst_m"), told.at("worst_m"));
  // A scene that asks for another motion than its path was found for.
  const std::string other = "choreography.waypoints=[{ t = 1.0, position = [0.3, 1.7, 0] }]";
  EXPECT_EQ(run_taut({"check", "scene.toml"}, folder.path()).output.find("is missed by"),
            std::string::npos);
  EXPECT_NE(run_taut({"check", "scene.toml", "--set", other}, folder.path())
                .output.find("warning: choreography: a waypoint is missed by "),
            std::string::npos);
}

TEST(Choreograph, EndsWhereItsBudgetDoes) {
  Folder folder;
  folder.write("scene.toml", kScene);
  const ProgramResult outcome =
      run_taut({"choreograph", "scene.toml", "--budget", "1e-6"}, folder.path());
  EXPECT_EQ(outcome.code, 2) << outcome.output;
  EXPECT_NE(outcome.messages.find("no path is found within --budget 1e-06 s of CPU time: 0 of "),
            std::string::npos)
      << outcome.messages;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "hand.csv"));
}

TEST(Choreograph, WritesNothingWhereNoPathComesSoNear) {
  Folder folder;
  const std::string fast =
      "[{ t = 0.5, position = [0.4, 1.7, 0] }, { t = 0.51, position = [-0.4, 1.7, 0] }]";
  folder.write("scene.toml", kScene);
  const ProgramResult outcome = run_taut(
      {"choreograph", "scene.toml", "--set", "choreography.waypoints=" + fast, "--set",
       "choreography.limits={ shoulder = [0, 2, 0], speed = 0.5 }", "--set",
       "choreography.until=1.0", "--set", "duration=1.2", "--set", "connectors.chain.particles=3"},
      folder.path());
  EXPECT_EQ(outcome.code, 2) << outcome.output;
  EXPECT_NE(outcome.messages.find("hand.csv is not written"), std::string::npos)
      << outcome.messages;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "hand.csv"));
}

TEST(Choreograph, NeedsAChoreography) {
  Folder folder;
  const ProgramResult outcome =
      run_taut({"choreograph", TAUT_SOURCE_DIR "/scenes/rope_swing.toml"}, folder.path());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.messages.find("has no [choreography]"), std::string::npos);
}

}  // namespace
}  // namespace taut::choreograph_test
