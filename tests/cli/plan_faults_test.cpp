// taut plan when it is asked for what cannot be, or is stopped.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <iterator>

#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

class PlanFaults : public testing::Test {
 protected:
  ProgramResult plan(const std::string& tolerance) const {
    return run_taut({"plan", "swing.toml", "--tolerance", tolerance}, folder_.path());
  }
  std::ptrdiff_t files() const {
    return std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator());
  }

  Folder folder_;
  fs::path scene_ = folder_.write("swing.toml", swing_scene(6.0));
};

TEST_F(PlanFaults, EndsWhereItsBudgetDoes) {
  const ProgramResult outcome =
      run_taut({"plan", "swing.toml", "--tolerance", "0.01mm", "--budget", "0.01"}, folder_.path());
  EXPECT_EQ(outcome.code, 2) << outcome.output;
  EXPECT_NE(outcome.messages.find("--budget 0.01: "), std::string::npos) << outcome.messages;
  EXPECT_NE(outcome.messages.find("% of what there is to compare with"), std::string::npos)
      << outcome.messages;
}

TEST_F(PlanFaults, StoppedItLeavesNothingBehind) {
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), {SIGTERM, 143}}) {
    const std::string before = read_file(scene_);
    Child child({TAUT_PROGRAM, "plan", scene_.string(), "--tolerance", "1px", "--write"},
                folder_.path());
    ASSERT_TRUE(child.runs_until([&] { return files() == 2; })) << "what --write will write";
    kill(child.id(), signal);
    const ProgramResult outcome = child.wait();
    EXPECT_EQ(outcome.code, code) << outcome.messages;
    const bool in_reference =
        outcome.messages.find("; solving the reference: ") != std::string::npos;
    const bool in_models = outcome.messages.find("; models: ") != std::string::npos;  // when slow
    EXPECT_TRUE(in_reference || in_models) << outcome.messages;
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(read_file(scene_), before);
    EXPECT_EQ(files(), 1);
  }
}

TEST_F(PlanFaults, TolerancesThatMakeNoSenseAreTold) {
  for (const char* tolerance : {"0", "0px", "-1px", "1", "px", "5 parsecs", "nanpx", "1e999px"}) {
    const ProgramResult outcome = plan(tolerance);
    EXPECT_EQ(outcome.code, 2) << tolerance;
    EXPECT_NE(outcome.messages.find("expected a number above 0 and px or mm, as in 1px"),
              std::string::npos)
        << tolerance << ": " << outcome.messages;
  }
}

TEST_F(PlanFaults, PixelsNeedACamera) {
  std::string text = swing_scene(0.2);
  text.erase(text.find("[stage]"));
  folder_.write("swing.toml", text);
  const ProgramResult outcome = plan("1px");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.messages.find("has no camera; give the tolerance in mm"), std::string::npos)
      << outcome.messages;
}

TEST_F(PlanFaults, WhatNothingReachesIsTold) {
  const ProgramResult outcome = plan("1e-15mm");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.messages.find("no method at any of its settings comes so near"),
            std::string::npos)
      << outcome.messages;
}

}  // namespace
}  // namespace taut
