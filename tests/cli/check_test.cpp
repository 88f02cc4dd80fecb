// taut check: what it says of scenes.
#include "render/cli/check.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scenes/load/load_scene.h"
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

nlohmann::json checked(const std::string& scene) {
  const Folder folder;
  folder.write("scene.toml", scene);
  const ProgramResult outcome = run_taut({"check", "scene.toml", "--json"}, folder.path());
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  return nlohmann::json::parse(outcome.output);
}

std::string hanging_rope(double duration, int fps, int particles, const std::string& method) {
  return fmt::format(
      "duration = {}\nfps = {}\n[method]\n{}\n[connectors.rope]\nlength = 1\nmass = 0.1\n"
      "particles = {}\nfrom = {{ fixed = [0, 1, 0] }}\nto = {{ free = true }}\n"
      "start = {{ direction = [1, 0, 0] }}\n",
      duration, fps, method, particles);
}

TEST(Check, MeasuresAShortRunToItsEnd) {
  const nlohmann::json run = checked(hanging_rope(0.1, 50, 5, "name = \"springs\"")).at("simulate");
  EXPECT_NEAR(run.at("measured_until_s").get<double>(), 0.08, 1e-12);
  EXPECT_EQ(run.at("at_least"), false);
  EXPECT_GT(run.at("time_s"), 0);
}

/// Whether some line has both words.
bool tells(const std::vector<std::string>& lines, const char* one, const char* other) {
  return std::ranges::any_of(lines, [&](const std::string& line) {
    return line.find(one) != std::string::npos && line.find(other) != std::string::npos;
  });
}

// A step of the first takes longer than the look may, a frame of the second.
TEST(Check, EndsHoweverLongARunTakes) {
  const nlohmann::json dense =
      checked(hanging_rope(5, 1, 3000, "name = \"dynamic-constraints\"\nsolver = \"dense\""));
  EXPECT_EQ(dense.at("simulate").at("at_least"), true);
  EXPECT_GT(dense.at("simulate").at("time_s"), 1);
  const nlohmann::json fine = checked(hanging_rope(100, 1, 100, "name = \"impulse\"\nstep = 2e-8"));
  EXPECT_LT(fine.at("simulate").at("measured_until_s"), 1);
  EXPECT_GT(fine.at("simulate").at("time_s"), 1000) << "5e9 steps of 100 particles";
  for (const nlohmann::json& one : {dense, fine}) {
    const auto warnings = one.at("warnings").get<std::vector<std::string>>();
    EXPECT_TRUE(tells(warnings, "the camera", "left out")) << one.at("warnings");
  }
  EXPECT_TRUE(tells(fine.at("warnings").get<std::vector<std::string>>(), "a step above 2e-08 s",
                    "fewer particles than 100"))
      << fine.at("warnings");
}

// At full length between two places that are held, no step of direct is small enough.
TEST(Check, SaysThatARunFails) {
  const nlohmann::json json = checked(
      "duration = 0.2\n[method]\nname = \"direct\"\n[connectors.rope]\nlength = 1\nmass = 0.1\n"
      "particles = 6\nfrom = { fixed = [0, 1, 0] }\nto = { fixed = [1, 1, 0] }\n");
  EXPECT_EQ(json.at("simulate").at("fails"), true);
  ASSERT_FALSE(json.at("warnings").empty());
  EXPECT_NE(json.at("warnings")[0].get<std::string>().find("diverges"), std::string::npos)
      << json.at("warnings");
}

std::vector<std::string> warnings_of(const std::string& scene) {
  return checked(scene).at("warnings").get<std::vector<std::string>>();
}

// Two ropes swing through each other, a body falls through the floor.
TEST(Check, WarnsOfWhatPassesThroughLater) {
  const std::string ropes = R"(duration = 0.6
[connectors.left]
length = 0.5
mass = 0.1
particles = 6
radius = 0.02
from = { fixed = [-0.1, 1, 0] }
to = { free = true }
start = { direction = [-1, 0, 0] }
[connectors.right]
length = 0.5
mass = 0.1
particles = 6
radius = 0.02
from = { fixed = [0.1, 1, 0] }
to = { free = true }
start = { direction = [1, 0, 0] }
)";
  const std::vector<std::string> crossed = warnings_of(ropes);
  EXPECT_TRUE(tells(crossed, "left and right pass through each other at ", "touching"));
  const std::vector<std::string> touching =
      warnings_of(ropes + "[touching.both]\nconnectors = [\"left\", \"right\"]\n");
  EXPECT_FALSE(tells(touching, "pass through", "touching"));

  const std::string floor = R"(duration = 0.6
[bodies.ball]
mass = 1
shape = { sphere = { diameter = 0.1 } }
position = [0, 0.5, 0]
EXTRA
[obstacles.floor]
shape = { plane = {} }
)";
  const auto with = [&](const std::string& extra) {
    std::string text = floor;
    return warnings_of(text.replace(text.find("EXTRA"), 5, extra));
  };
  EXPECT_TRUE(tells(with(""), "ball passes through obstacle floor at ", "contact = {}"));
  EXPECT_FALSE(tells(with("contact = {}"), "passes", "floor"));
}

scenes::Scene rope_of_direct(const Folder& folder) {
  folder.write("scene.toml", hanging_rope(0.5, 30, 20, "name = \"direct\""));
  return scenes::load_scene(folder.path() / "scene.toml", false);
}

TEST(Check, NamesACheaperMethodThatAgrees) {
  const Folder folder;
  const scenes::Scene scene = rope_of_direct(folder);
  cli::Piece piece;
  Simulation simulation = scenes::start(scene);
  for (int frame = 0; frame < scene.frames(); ++frame) {
    simulation.advance_to(frame / 30.0);
    piece.states.push_back(simulation.state());
  }
  cli::RunTime time;
  time.seconds = time.least = time.most = 1e4;
  const auto cheaper = cli::cheaper_method(scene, time, 0, piece, 100);
  ASSERT_TRUE(cheaper);
  EXPECT_EQ(cheaper->method.name, "xpbd");
  EXPECT_GT(cheaper->apart, 0);
  EXPECT_LE(cheaper->apart, 0.01);
  EXPECT_NEAR(cheaper->until, 14 / 30.0, 1e-9);
  EXPECT_NE(cli::text_of(*cheaper, time, scene).find("--method xpbd --step "), std::string::npos);

  EXPECT_FALSE(cli::cheaper_method(scene, time, 1e3, piece, 100)) << "reading takes a tenth of it";
  piece.states.resize(2);
  EXPECT_FALSE(cli::cheaper_method(scene, time, 0, piece, 100)) << "nothing moved yet";
}

TEST(Check, TellsARunFromItsPiece) {
  const Folder folder;
  const scenes::Scene scene = rope_of_direct(folder);
  const double frame = 1 / 30.0;
  cli::Piece piece;
  piece.marks = {{0, 0}, {frame, 1}, {2 * frame, 2}};
  piece.unfinished = 1, piece.next = frame;
  const cli::RunTime even = cli::time_of_run(scene, 0.5, piece);
  EXPECT_NEAR(even.seconds, 0.5 + 3 + 12, 1e-9);
  EXPECT_FALSE(even.at_least);

  piece.marks = {{0, 0}, {frame, 1}, {2 * frame, 4}};
  piece.unfinished = 0;
  const cli::RunTime rising = cli::time_of_run(scene, 0, piece);
  EXPECT_NEAR(rising.most, 4 + 12 * 3, 1e-9);
  EXPECT_GT(rising.seconds, rising.least);
  EXPECT_LT(rising.seconds, rising.most);

  piece.marks = {{0, 0.1}};
  piece.unfinished = 0.5;
  const cli::RunTime no_step = cli::time_of_run(scene, 0, piece);
  EXPECT_TRUE(no_step.at_least);
  EXPECT_NEAR(no_step.seconds, 0.6 + 0.5 * 14, 1e-9);
}

// What takes more memory than a look may is not run at all.
TEST(Check, SaysWhereTheTimeIsNotKnown) {
  const nlohmann::json json =
      checked(hanging_rope(1, 60, 100'000, "name = \"dynamic-constraints\"\nsolver = \"dense\""));
  EXPECT_TRUE(json.at("simulate").at("time_s").is_null());
}

template <class Entries>
void expect_good(const Entries& entries) {
  for (const fs::directory_entry& entry : entries) {
    if (entry.path().extension() != ".toml") continue;
    const ProgramResult outcome = run_taut({"check", entry.path().string()});
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
  }
}

TEST(Check, ShippedScenesAreGood) {
  expect_good(fs::directory_iterator(TAUT_SOURCE_DIR "/scenes/tutorial"));
  expect_good(fs::directory_iterator(TAUT_SOURCE_DIR "/scenes/hard"));
}

// check measures a piece of each: minutes for all of them.
TEST(LongCheck, EveryShippedSceneIsGood) {
  expect_good(fs::recursive_directory_iterator(TAUT_SOURCE_DIR "/scenes"));
}

TEST(Check, SchemaIsTheOneThatIsShipped) {
  const ProgramResult outcome = run_taut({"check", "--schema"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(outcome.output == read_file(TAUT_SOURCE_DIR "/scenes/scene.schema.json"))
      << "the format or a method changed; run: taut check --schema > scenes/scene.schema.json";
}

}  // namespace
}  // namespace taut::check_test
