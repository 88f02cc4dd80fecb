// Limits of work: where they end it, and whose they are.
#include <gtest/gtest.h>

#include <thread>

#include "sim/motion/stop.h"
#include "sim/run/simulation.h"

namespace taut::work_limit_test {
namespace {

void check_times(int count) {
  for (int i = 0; i < count; ++i) check_stop();
}

TEST(WorkLimit, AllowsSoManyChecks) {
  WorkLimit limit({.checks = 10});
  check_times(10);
  EXPECT_FALSE(limit.reached());
  EXPECT_THROW(check_stop(), OverLimit);
  EXPECT_TRUE(limit.reached());
  EXPECT_THROW(check_stop(), OverLimit) << "and no more from then on";
}

TEST(WorkLimit, TellsWhichOfTwoEndedTheWork) {
  WorkLimit outer({.checks = 5});
  {
    WorkLimit inner({.checks = 3});
    EXPECT_THROW(check_times(4), OverLimit);
    EXPECT_TRUE(inner.reached());
    EXPECT_FALSE(outer.reached());
  }
  WorkLimit inner({.checks = 100});
  EXPECT_THROW(check_times(3), OverLimit);
  EXPECT_FALSE(inner.reached());
  EXPECT_TRUE(outer.reached());
}

TEST(WorkLimit, IsOfItsThreadAlone) {
  WorkLimit limit({.checks = 0});
  bool ended = false;
  std::thread other([&] {
    try {
      check_times(10);
      ended = true;
    } catch (const OverLimit&) {
    }
  });
  other.join();
  EXPECT_TRUE(ended);
}

TEST(WorkLimit, EndsWorkByItsCpuTime) {
  const double start = thread_seconds();
  WorkLimit limit({.cpu_time = 0.02});
  EXPECT_THROW(
      {
        while (thread_seconds() - start < 20) check_stop();
      },
      OverLimit);
  EXPECT_GE(thread_seconds() - start, 0.02);
}

// A single advance to far beyond what the limit allows.
TEST(WorkLimit, EndsEveryMethodWithinAnAdvance) {
  World world;
  Connector rope = straight_connector("rope", 1, 0.1, 11, {0, 0, 0}, {1, 0, 0});
  rope.holds.push_back({0, Attachment{}});
  world.connectors.push_back(std::move(rope));
  finish(world);
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty() || !follows(method, world)) continue;
    Simulation simulation(world, make_method(method.name, {}));
    WorkLimit limit({.checks = 20});
    EXPECT_THROW(simulation.advance_to(1000), OverLimit) << method.name;
  }
}

}  // namespace
}  // namespace taut::work_limit_test
