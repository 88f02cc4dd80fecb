// Whoever stops a command that solves a truth or an estimate learns how far it was.
#include <gtest/gtest.h>

#include <cctype>
#include <sstream>
#include <thread>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

/// The result of a command interrupted while it does `work`: later, where it had not begun.
ProgramResult interrupted(const std::vector<std::string>& command, const std::string& work) {
  const Folder folder;
  folder.write("scene.toml",
               "duration = 200\nfps = 60\n[connectors.rope]\nlength = 1\nmass = 0.1\n"
               "particles = 60\nfrom = { fixed = [0, 2, 0] }\nto = { free = true }\n"
               "start = { direction = [1, 0, 0] }\n"
               "[stage]\ncamera = [{ t = 0, position = [0, 1, 3], target = [0, 1, 0], "
               "field_of_view = 0.6 }]\n");
  std::vector<std::string> words{TAUT_PROGRAM};
  words.insert(words.end(), command.begin(), command.end());
  ProgramResult outcome;
  for (auto wait = std::chrono::milliseconds(400); wait < std::chrono::seconds(60); wait *= 2) {
    Child child(words, folder.path());
    std::this_thread::sleep_for(wait);
    kill(child.id(), SIGINT);
    outcome = child.wait();
    if (outcome.messages.find("; " + work) != std::string::npos) break;
  }
  return outcome;
}

TEST(Interrupted, TheTruthSaysHowFarItIs) {
  const std::string work = "solving the truth: ";
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"simulate", "scene.toml", "--score", "1e-4"},
        {"compare", "scene.toml"}}) {
    const ProgramResult outcome = interrupted(command, work);
    EXPECT_EQ(outcome.code, 130) << outcome.messages;
    EXPECT_NE(outcome.messages.find("taut: interrupted; " + work), std::string::npos)
        << command[0] << outcome.messages;
    // Of four runs; whether the last frame is one of them is the command's own affair.
    EXPECT_NE(outcome.messages.find(" of 4800"), std::string::npos) << outcome.messages;
    EXPECT_EQ(outcome.output, "");
  }
}

TEST(Interrupted, TheEstimateBesideARunSaysHowFarItIs) {
  const ProgramResult outcome = interrupted(
      {"simulate", "scene.toml", "--method", "truth", "--csv", "t.csv"}, "simulating: ");
  EXPECT_EQ(outcome.code, 130) << outcome.messages;
  EXPECT_NE(outcome.messages.find(" of 12000 frames"), std::string::npos) << outcome.messages;
}

/// A frame of the rope has 100,000 steps.
constexpr const char* kLongFrames = R"(duration = 20
fps = 1
[method]
name = "direct"
step = 1e-5
[connectors.rope]
length = 1
mass = 0.1
particles = 200
from = { fixed = [0, 2, 0] }
to = { free = true }
start = { direction = [1, 0, 0] }
[stage]
camera = [{ t = 0, position = [0, 1, 3], target = [0, 1, 0], field_of_view = 0.6 }]
)";

class EachCommand : public testing::TestWithParam<const char*> {};

/// What it had begun is not there, wherever in it the signal comes.
TEST_P(EachCommand, EndsWithinAStep) {
  const Folder folder;
  folder.write("CMakePresets.json", "{}");
  folder.write("scene.toml", kLongFrames);
  folder.write("kept/golden.toml", "[trajectories.swing]\nscene = \"scene.toml\"\nuntil = 19\n");
  std::istringstream words(GetParam());
  std::vector<std::string> command{TAUT_PROGRAM};
  for (std::string word; words >> word;) command.push_back(word);
  for (const auto& [signal, code] : {std::pair(SIGTERM, 143), {SIGINT, 130}}) {
    Child child(command, folder.path());
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    const double before = child.cpu_seconds();
    kill(child.id(), signal);
    const ProgramResult outcome = child.wait();
    EXPECT_EQ(outcome.code, code) << outcome.messages;
    constexpr double kSoon = 5;  // s of CPU time, of a minute and more
    EXPECT_LT(outcome.cpu_seconds - before, kSoon);
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, EachCommand,
    testing::Values("simulate scene.toml --csv t.csv", "simulate scene.toml --method truth",
                    "simulate scene.toml --method xpbd --step 1e-5 --csv t.csv",
                    "render scene.toml --size 32x18 --out o --no-video",
                    "compare scene.toml --size 32x18 --out o --no-video",
                    "export scene.toml -o t.npz", "golden accept kept", "chart scene.toml --out o",
                    "stability scene.toml --out o", "bench scene.toml --out o",
                    "classify scene.toml", "report scene.toml --out o", "work-precision scene.toml",
                    "plan scene.toml --tolerance 1mm"),
    [](const auto& command) {
      std::string name;
      for (const char c : std::string(command.param)) {
        if (std::isalnum(static_cast<unsigned char>(c))) name += c;
      }
      return name;
    });

}  // namespace
}  // namespace taut
