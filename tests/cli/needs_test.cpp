// Runs that no machine can hold are refused before they start, with what they would take and what
// to change; those that take long say so.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/cli/swing_scene.h"
#include "tests/support/fault_table.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

class Needs : public testing::Test {
 protected:
  /// A rope of so many particles that swings for so long (s).
  std::string rope(int particles, double duration, int fps = 60) const {
    return fmt::format(
        "duration = {}\nfps = {}\n[connectors.rope]\nlength = 1\nmass = 0.1\nparticles = {}\n"
        "from = {{ fixed = [0, 1, 0] }}\nto = {{ free = true }}\n",
        duration, fps, particles);
  }
  ProgramResult run(std::vector<std::string> arguments) const {
    return run_taut(std::move(arguments), folder_.path());
  }
  ProgramResult refused(int code, const std::vector<std::string>& says,
                        const std::vector<std::string>& arguments) const {
    const ProgramResult outcome = run(arguments);
    EXPECT_EQ(outcome.code, code) << outcome.messages;
    EXPECT_EQ(outcome.output, "");
    for (const std::string& part : says) {
      EXPECT_NE(outcome.messages.find(part), std::string::npos) << outcome.messages;
    }
    return outcome;
  }

  Folder folder_;
};

TEST_F(Needs, MoreMemoryThanAllowedIsRefused) {
  FaultTable table("More than a machine has", folder_.path());
  folder_.write("rope.toml", rope(100'000, 1));
  folder_.write("swing.toml", swing_scene(6.0));
  folder_.write("day.toml", swing_scene(86400));
  // 18 bytes for each of 99,999^2 pairs of links.
  table.add("a dense matrix of 100,000 links",
            refused(3,
                    {"rope.toml:1:1: would take about 180 GB of memory by dynamic-constraints, "
                     "expected at most 100 GB (--max-memory)",
                     "solver = \"tridiagonal\""},
                    {"simulate", "rope.toml", "--method", "dynamic-constraints", "--set",
                     "solver=dense", "--max-memory", "100GB"}));
  table.add("100,000 particles by multibody",
            refused(3, {" MB of memory by multibody, expected at most 500 MB"},
                    {"simulate", "rope.toml", "--method", "multibody", "--max-memory", "500MB"}));
  table.add("a clip", refused(3, {"expected at most 1 MB", "(--frames)"},
                              {"render", "swing.toml", "--max-memory", "1MB", "--threads", "2"}));
  table.add(
      "a day at 1000 frames a second",
      refused(3, {"day.toml:1:1: would take about ", " GB of memory"},
              {"render", "day.toml", "--fps", "1000", "--max-memory", "8GB", "--threads", "2"}));
  EXPECT_TRUE(table.is_as_accepted());
}

TEST_F(Needs, MoreDiskThanThereIsIsRefused) {
  folder_.write("rope.toml", rope(100'000, 86400, 1000));
  // 86.4 million rows of 300,001 numbers of 19 bytes.
  refused(6, {"the output would take about 490 TB, the disk has ", "a shorter scene, fewer frames"},
          {"simulate", "rope.toml", "--csv", "t.csv"});
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "t.csv"));
}

TEST_F(Needs, WhatTakesLongSaysSo) {
  folder_.write("rope.toml", rope(100, 1) + "[method]\nname = \"impulse\"\nstep = 1e-9\n");
  Child child({TAUT_PROGRAM, "simulate", "rope.toml", "--csv", "t.csv"}, folder_.path());
  EXPECT_EQ(child.messages_until("\n").find("this will take "), 0u);
}

TEST_F(Needs, CheckSaysThem) {
  folder_.write("rope.toml", rope(100'000, 1) +
                                 "[method]\nname = \"dynamic-constraints\"\nsolver = \"dense\"\n");
  const ProgramResult outcome = run({"check", "rope.toml"});
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_NE(outcome.output.find("taut simulate takes about 180 GB of memory, 340 MB of disk and "),
            std::string::npos)
      << outcome.output;
  folder_.write("swing.toml", swing_scene(6.0));
  const auto json = nlohmann::json::parse(run({"check", "swing.toml", "--json"}).output);
  for (const char* command : {"simulate", "render"}) {
    for (const char* need : {"memory_bytes", "disk_bytes", "time_s"}) {
      EXPECT_GT(json.at(command).at(need), 0) << command << need;
    }
  }
}

/// The peak of a command's memory, in bytes; negative where it fails.
double memory_of(const std::filesystem::path& folder, std::vector<std::string> command) {
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (chdir(folder.c_str()) == 0) execv(words[0], words.data());
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  return status == 0 ? 1024.0 * double(usage.ru_maxrss) : -1;
}

using LongNeeds = Needs;

// Each on a rope of its own, at a time of its own.
TEST_F(LongNeeds, PinsAndCutsTakeWhatCheckSays) {
  constexpr int kRopes = 1500;
  for (const bool pins : {true, false}) {
    std::string scene = "duration = 0.5\nfps = 10\n";
    for (int i = 0; i < kRopes; ++i) {
      const double time = 0.1 + 0.3 * (i + 0.3) / kRopes;
      scene += pins ? fmt::format("[[pins]]\nconnector = \"r{}\"\nat = 0.5\nfrom = {}\n", i, time)
                    : fmt::format("[[cuts]]\nconnector = \"r{}\"\nat = 0.5\nt = {}\n", i, time);
      scene += fmt::format(
          "[connectors.r{}]\nlength = 1\nmass = 0.1\nparticles = 5\nfrom = {{ fixed = [{}, 1, 0] "
          "}}\n"
          "to = {{ free = true }}\nstart = {{ direction = [0.8, -0.6, 0.0] }}\n",
          i, 0.1 * i);
    }
    for (const char* method : {"direct", "springs"}) {
      folder_.write("scene.toml", scene + fmt::format("[method]\nname = \"{}\"\n", method));
      const ProgramResult check = run({"check", "scene.toml", "--json"});
      ASSERT_EQ(check.code, 0) << check.messages;
      const double told =
          nlohmann::json::parse(check.output).at("simulate").at("memory_bytes").get<double>();
      const double taken = memory_of(
          folder_.path(), {TAUT_PROGRAM, "simulate", "scene.toml", "-q", "--csv", "t.csv"});
      EXPECT_LE(taken, told) << method << pins;
      EXPECT_GE(taken, told / 8) << method << pins;
    }
  }
}

}  // namespace
}  // namespace taut
