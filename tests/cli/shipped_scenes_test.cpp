// The scenes that are shipped run to their ends.
#include <gtest/gtest.h>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

void expect_ends(const fs::path& folder) {
  const Folder out;
  for (const auto& entry : fs::directory_iterator(fs::path(TAUT_SOURCE_DIR) / "scenes" / folder)) {
    if (entry.path().extension() != ".toml") continue;
    const ProgramResult outcome = run_taut(
        {"simulate", entry.path().string(), "--csv", "motion.csv", "--no-estimate"}, out.path());
    EXPECT_EQ(outcome.code, 0) << entry.path() << ": " << outcome.messages;
  }
}

TEST(ShippedScenes, RunToTheirEnds) {
  for (const char* folder : {"", "materials", "choreography", "tutorial"}) expect_ends(folder);
}

TEST(LongShippedScenes, RunToTheirEnds) {
  for (const char* folder : {"contact", "topology"}) expect_ends(folder);
}

}  // namespace
}  // namespace taut
