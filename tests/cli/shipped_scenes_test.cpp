// The scenes that are shipped run to their ends.
#include <gtest/gtest.h>

#include <set>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

/// A thousand cords; a scene that moves as the one that it extends.
const std::set<fs::path> kSlow{"bead_curtain.toml", "nunchaku_edit.toml"};

void expect_ends(const fs::path& folder, bool slow_ones) {
  const Folder out;
  for (const auto& entry : fs::directory_iterator(fs::path(TAUT_SOURCE_DIR) / "scenes" / folder)) {
    if (entry.path().extension() != ".toml") continue;
    if (kSlow.contains(entry.path().filename()) && !slow_ones) continue;
    const ProgramResult outcome = run_taut(
        {"simulate", entry.path().string(), "--csv", "motion.csv", "--no-estimate"}, out.path());
    EXPECT_EQ(outcome.code, 0) << entry.path() << ": " << outcome.messages;
  }
}

TEST(ShippedScenes, RunToTheirEnds) {
  for (const char* folder : {"", "materials", "choreography", "tutorial"})
    expect_ends(folder, false);
}

TEST(LongShippedScenes, RunToTheirEnds) {
  for (const char* folder : {"", "contact", "topology", "new"}) expect_ends(folder, true);
}

}  // namespace
}  // namespace taut
