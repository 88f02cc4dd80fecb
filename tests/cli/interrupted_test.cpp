// Whoever stops a command that solves a truth or an estimate learns how far it was.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace taut
