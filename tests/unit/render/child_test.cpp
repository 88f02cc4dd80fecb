#include "render/base/child.h"

#include <gtest/gtest.h>

namespace taut::child_test {
namespace {

TEST(Child, GivesOutputErrorsAndStatus) {
  const std::string big(3 << 20, 'x');  // more than any pipe holds
  const render::ChildResult copy = render::run_child({"cat"}, big);
  EXPECT_EQ(copy.status, 0);
  EXPECT_EQ(copy.output, big);
  const render::ChildResult failed = render::run_child({"cat", "/nonexistent/file"}, "");
  EXPECT_EQ(failed.status, 1);
  EXPECT_NE(failed.errors.find("/nonexistent/file"), std::string::npos);
}

TEST(Child, IsKilledWhereItDoesNothing) {
  const render::ChildResult blocked =
      render::run_child({"sleep", "1000"}, "", {.patience = std::chrono::milliseconds(200)});
  EXPECT_EQ(blocked.status, 128 + 9);
  EXPECT_NE(blocked.errors.find("sleep did nothing for too long"), std::string::npos);
}

TEST(Child, MayTakeItsTimeWhereItWorks) {
  // A second of work, with patience for a tenth of it.
  const render::ChildResult busy =
      render::run_child({"sh", "-c", "i=0; while [ $i -lt 1000000 ]; do i=$((i + 1)); done"}, "",
                        {.patience = std::chrono::milliseconds(100)});
  EXPECT_EQ(busy.status, 0) << busy.errors;
  EXPECT_GT(busy.cpu_time, 0);
}

TEST(Child, IsEndedBeyondItsLimits) {
  EXPECT_EQ(render::run_child({"head", "-c", "3000", "/dev/zero"}, "", {.output = 1000}).status,
            128 + 25);
  const render::ChildResult endless =
      render::run_child({"sh", "-c", "while :; do :; done"}, "", {.cpu_time = 1});
  EXPECT_EQ(endless.status, 128 + 24);
  EXPECT_GE(endless.cpu_time, 0.9);
}

}  // namespace
}  // namespace taut::child_test
