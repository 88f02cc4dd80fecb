// Every suite of golden pictures in this folder looks as it was accepted. After a change that is
// meant, look at the pictures (the failure says where they are) and take them over:
//   build/release/taut golden accept tests/golden/SUITE
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut::suites_test {
namespace {

namespace fs = std::filesystem;

const fs::path kGoldens = fs::path(TAUT_SOURCE_DIR) / "tests/golden";

std::vector<std::string> suites() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(kGoldens))
    if (fs::exists(entry.path() / "golden.toml")) names.push_back(entry.path().filename());
  std::ranges::sort(names);
  return names;
}

class GoldenSuites : public testing::TestWithParam<std::string> {
 protected:
  ProgramResult check(std::vector<std::string> more = {}) {
    std::vector<std::string> command = {"golden", "check", kGoldens / GetParam(), "--quiet"};
    command.insert(command.end(), more.begin(), more.end());
    return run_taut(command);
  }
};

TEST_P(GoldenSuites, LookAsAccepted) {
  const ProgramResult outcome = check();
  EXPECT_EQ(outcome.code, 0) << outcome.output << outcome.messages;
}

/// Mesa's rasteriser draws as on the processors of twenty years ago.
void expect_as_accepted_with_short_vectors(std::vector<std::string> more) {
  std::vector<std::string> command = {"env",        "GALLIUM_OVERRIDE_CPU_CAPS=sse2",
                                      TAUT_PROGRAM, "golden",
                                      "check",      kGoldens / "scenes",
                                      "--quiet"};
  command.insert(command.end(), more.begin(), more.end());
  const ProgramResult outcome = Child(command, TAUT_SOURCE_DIR).wait();
  EXPECT_EQ(outcome.code, 0) << outcome.output << outcome.messages;
}

TEST(ShortVectors, ASceneLooksAsAccepted) {
  expect_as_accepted_with_short_vectors({"--only=nunchaku_spin"});
}

TEST(LongShortVectors, AllScenesLookAsAccepted) {
  expect_as_accepted_with_short_vectors({});
}

INSTANTIATE_TEST_SUITE_P(All, GoldenSuites, testing::ValuesIn(suites()),
                         [](const auto& suite) { return suite.param; });

// 11 particles that swing for half a second.
constexpr const char* kScene = R"(
schema_version = 1
duration = 0.5
fps = 20
method = { name = "impulse", step = 0.005 }
[connectors.rope]
length = 0.2
mass = 0.05
particles = 11
from = { fixed = [0, 0.2, 0] }
to = { point_mass = 0.2 }
start = { direction = [1, 0, 0] }
look = "rope"
diameter = 0.007
[stage]
camera = [{ t = 0, position = [0, 0.1, 1], target = [0, 0.1, 0] }]
)";
constexpr const char* kSuite = R"(
schema_version = 1
size = [160, 90]
[frames.early]
scene = "scenes/swing.toml"
time = 0.1
[frames.late]
scene = "scenes/swing.toml"
time = 0.4
)";

/// A small suite, to be spoilt.
class GoldenCommand : public testing::Test {
 protected:
  void SetUp() override {
    // Scenes are found from the suite's repository: here that is the folder.
    folder_.write("CMakePresets.json", "{}");
    folder_.write("scenes/swing.toml", kScene);
    folder_.write("suite/golden.toml", kSuite);
    ASSERT_EQ(golden({"accept", "suite"}).output, "early: new\nlate: new\n");
  }
  ProgramResult golden(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "golden");
    return run_taut(arguments, folder_.path());
  }

  Folder folder_;
  fs::path suite_ = folder_.path() / "suite";
};

// A folder beside scenes that are in no repository and have no stage of their own.
TEST(GoldenSuite, MayBeAnywhere) {
  const Folder folder;
  std::string scene = kScene;
  scene.erase(scene.find("[stage]"));
  folder.write("rope.toml", scene);
  folder.write("goldens/golden.toml",
               "size = [64, 36]\n[frames.early]\nscene = \"../rope.toml\"\ntime = 0.1\n");
  const ProgramResult accepted = run_taut({"golden", "accept", folder.path() / "goldens"}, "/");
  EXPECT_EQ(accepted.output, "early: new\n") << accepted.messages;
  // The page's example of a CI job runs there.
  const std::string page = read_file(fs::path(TAUT_SOURCE_DIR) / "render/README.md");
  const std::string step = "- run: taut ";
  const std::size_t at = page.find(step);
  ASSERT_NE(at, std::string::npos);
  std::istringstream words(page.substr(at + step.size(), page.find('\n', at) - at - step.size()));
  const std::vector<std::string> job{std::istream_iterator<std::string>(words), {}};
  EXPECT_EQ(run_taut(job, folder.path()).code, 0);
  folder.write("rope.toml",
               scene + "[obstacles.wall]\nshape = { box = { size = [0.1, 0.1, 0.1] } }\n");
  EXPECT_EQ(run_taut(job, folder.path()).code, 1);
  EXPECT_TRUE(fs::exists(folder.path() / "differences/early/difference.png"));
  folder.write("goldens/golden.toml",
               "size = [64, 36]\n[frames.early]\nscene = \"../../etc/passwd\"\ntime = 0.1\n");
  EXPECT_EQ(run_taut({"golden", "check", "goldens"}, folder.path()).code, 3);
}

TEST_F(GoldenCommand, AcceptingLeavesFilesOfWhatIsAsBefore) {
  const std::string record = read_file(suite_ / "late.json") + "\n\n";
  std::ofstream(suite_ / "late.json") << record;
  EXPECT_EQ(golden({"accept", "suite", "--only", "late"}).output, "late: as before\n");
  EXPECT_EQ(read_file(suite_ / "late.json"), record);
}

TEST_F(GoldenCommand, LeavesWhatIsNeededToJudgeADifference) {
  // The first frame is compared with the picture of the second.
  fs::copy_file(suite_ / "late.png", suite_ / "early.png", fs::copy_options::overwrite_existing);
  const ProgramResult outcome = golden({"check", "suite", "--only", "early"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.output.find("early: "), std::string::npos) << outcome.output;
  const fs::path out = folder_.path() / "out/golden/suite";
  for (const char* file : {"index.html", "report.json", "early/actual.png", "early/golden.png",
                           "early/difference.png"})
    EXPECT_TRUE(fs::exists(out / file)) << file;

  // Accepted, it is right again, and what was left is gone.
  EXPECT_EQ(golden({"accept", "suite", "--only", "early"}).output, "early: changed\n");
  EXPECT_EQ(golden({"check", "suite", "--only", "early"}).code, 0);
  EXPECT_FALSE(fs::exists(out / "index.html"));
  EXPECT_FALSE(fs::exists(out / "early"));
}

TEST_F(GoldenCommand, AnotherSizeIsADifferenceToAccept) {
  const std::string suite = read_file(suite_ / "golden.toml");
  const std::string_view size = "size = [160, 90]";
  ASSERT_NE(suite.find(size), std::string::npos);
  std::ofstream(suite_ / "golden.toml")
      << std::string(suite).replace(suite.find(size), size.size(), "size = [80, 45]");
  const ProgramResult outcome = golden({"check", "suite", "--only", "early"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.output.find("is of 160x90 pixels and the suite of 80x45"), std::string::npos)
      << outcome.output;
  EXPECT_EQ(golden({"accept", "suite", "--only", "early"}).output, "early: changed\n");
  EXPECT_EQ(golden({"check", "suite", "--only", "early"}).code, 0);
}

TEST_F(GoldenCommand, ASceneThatMovesOtherwiseIsADifferenceToAccept) {
  nlohmann::json record = nlohmann::json::parse(read_file(suite_ / "early.json"));
  nlohmann::json& height = record["state"]["connectors"][0][5][1];
  height = height.get<double>() + 1e-5;  // m; `within` is 1e-6
  std::ofstream(suite_ / "early.json") << record;
  EXPECT_EQ(golden({"check", "suite", "--only", "early"}).code, 1);
  EXPECT_EQ(golden({"accept", "suite", "--only", "early"}).output, "early: changed\n");
  EXPECT_EQ(golden({"check", "suite", "--only", "early"}).code, 0);
}

/// A suite of one motion whose kept record is changed.
class GoldenMotion : public GoldenCommand {
 protected:
  void SetUp() override {
    GoldenCommand::SetUp();
    folder_.write("motions/golden.toml",
                  "[trajectories.swing]\nscene = \"scenes/swing.toml\"\nuntil = 0.2\n");
    ASSERT_EQ(golden({"accept", "motions"}).output, "swing: new\n");
    ASSERT_EQ(golden({"check", "motions"}).output, "1 as kept\n");
  }
  /// The result of a check once `change` was made to the record.
  ProgramResult after(const std::function<void(nlohmann::json&)>& change) {
    nlohmann::json record = nlohmann::json::parse(read_file(record_));
    change(record);
    std::ofstream(record_) << record;
    return golden({"check", "motions"});
  }

  /// Moves one particle of one kept state by that distance, m.
  static std::function<void(nlohmann::json&)> moved_by(double distance) {
    return [distance](nlohmann::json& record) {
      nlohmann::json& x = record["states"][3]["connectors"][0][7][0];
      x = x.get<double>() + distance;
    };
  }

  fs::path record_ = folder_.path() / "motions/swing.trajectory.json";
};

TEST_F(GoldenMotion, IsComparedByDistance) {
  EXPECT_EQ(after(moved_by(0.9e-6)).code, 0);
  EXPECT_EQ(golden({"accept", "motions"}).output, "swing: as before\n");
  EXPECT_EQ(after(moved_by(0.2e-6)).code, 1) << "1.1 um by now";
  EXPECT_EQ(golden({"accept", "motions"}).output, "swing: changed\n");
  EXPECT_EQ(golden({"check", "motions"}).code, 0);
}

TEST_F(GoldenMotion, IsWithinTwiceTheTolerance) {
  folder_.write("motions/golden.toml",
                "[trajectories.swing]\nscene = \"scenes/swing.toml\"\nuntil = 0.2\n"
                "method = { name = \"direct\", tolerance = 1e-4 }\n");
  ASSERT_EQ(golden({"accept", "motions"}).output, "swing: changed\n");
  EXPECT_EQ(after(moved_by(1.9e-4)).code, 0);
  EXPECT_EQ(after(moved_by(0.2e-4)).code, 1) << "2.1e-4 m by now";
}

TEST_F(GoldenMotion, OfAnotherWorldIsADifference) {
  EXPECT_EQ(after([](auto& record) { record["states"][0]["connectors"][0].erase(0); }).code, 1);
}

TEST_F(GoldenCommand, NothingKeptIsADifference) {
  fs::remove(suite_ / "early.json");
  const ProgramResult outcome = golden({"check", "suite", "--only", "early"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.output.find("nothing is kept of it yet"), std::string::npos);
}

TEST_F(GoldenCommand, SaysWhatIsWrongWithASuite) {
  EXPECT_EQ(golden({"check", "nowhere"}).code, 3);
  EXPECT_EQ(golden({"check", "suite", "--only", "nothing"}).code, 2);
  std::ofstream(suite_ / "early.json") << "{}";
  const ProgramResult outcome = golden({"check", "suite", "--only", "early"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.messages.find("early.json: no record"), std::string::npos) << outcome.messages;
  std::ofstream(suite_ / "golden.toml") << "[frames.a]\nscene = \"scenes/swing.toml\"\ntime = 99\n";
  EXPECT_NE(golden({"check", "suite"}).messages.find("golden.toml:3:8: frames.a.time: found 99"),
            std::string::npos);
}

}  // namespace
}  // namespace taut::suites_test
