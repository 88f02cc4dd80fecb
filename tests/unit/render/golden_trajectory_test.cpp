// The message on a motion that is another one than was accepted.
#include "render/golden/golden_trajectory.h"

#include <gtest/gtest.h>

#include "tests/support/folder.h"

namespace taut::golden_trajectory_test {
namespace {

constexpr const char* kSwing = R"(duration = 0.2
fps = 20
[connectors.rope]
length = 0.2
mass = 0.05
particles = 4
from = { fixed = [0, 0.6, 0] }
to = { free = true }
start = { direction = [1, 0, 0] }
)";

TEST(GoldenTrajectory, SaysWhatOfTheSceneChanged) {
  const Folder folder;
  scenes::GoldenTrajectory golden;
  golden.scene = folder.write("scene.toml", kSwing);
  golden.last = 3;
  golden.method = {"direct", {}};
  golden.within = 1e-9;
  const golden::TrajectoryRecord before = golden::record_of(golden);
  const auto kept =
      golden::read_trajectory(folder.write("kept.json", golden::trajectory_text(before)));
  EXPECT_EQ(golden::compare(before, kept, golden.within).failure, "");
  std::string other = kSwing;
  folder.write("scene.toml", other.replace(other.find("length = 0.2"), 12, "length = 0.3"));
  const std::string failure =
      golden::compare(golden::record_of(golden), kept, golden.within).failure;
  EXPECT_NE(failure.find("since it was accepted connectors.rope.length was 0.2 and is 0.3"),
            std::string::npos)
      << failure;
  golden.method = {"direct", {{"tolerance", 1e-7}}};
  EXPECT_NE(golden::compare(golden::record_of(golden), kept, golden.within)
                .failure.find("method.tolerance is new"),
            std::string::npos);
}

}  // namespace
}  // namespace taut::golden_trajectory_test
