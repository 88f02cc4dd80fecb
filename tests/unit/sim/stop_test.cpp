// The stop check ends every method within a frame.
#include "sim/motion/stop.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>

#include "sim/motion/side_by_side.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"

namespace taut::stop_test {
namespace {

struct Stopped {};

std::atomic<int> left = 0;

void count_down() {
  if (--left < 0) throw Stopped();
}

class StopTest : public testing::Test {
 protected:
  ~StopTest() override { set_stop_check(nullptr); }
};

World swing() {
  World world;
  Connector rope;
  rope.name = "rope";
  rope.mass = 0.1;
  rope.length = 1;
  for (int i = 0; i < 11; ++i) {
    rope.position.emplace_back(0.1 * i, 0, 0);
    rope.velocity.push_back(Vec3::Zero());
    rope.particle_mass.push_back(0.1 / 11);
    if (i > 0) rope.rest.push_back(0.1);
  }
  Hold hold;
  rope.holds = {hold};
  world.connectors = {rope};
  finish(world);
  return world;
}

TEST_F(StopTest, EndsEachMethodWithinAFrame) {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty()) continue;
    set_stop_check(nullptr);
    Simulation simulation(swing(), make_method(method.name, {}));
    simulation.advance_to(0.01);
    left = 3;
    set_stop_check(count_down);
    EXPECT_THROW(simulation.advance_to(100), Stopped) << method.name;
    set_stop_check(nullptr);
    EXPECT_THROW(simulation.advance_to(100.1), std::runtime_error) << method.name;
  }
}

TEST_F(StopTest, EndsWorkOnSeveralThreads) {
  left = 5;
  set_stop_check(count_down);
  std::atomic<int> done = 0;
  EXPECT_THROW(side_by_side(1000, [&](std::size_t) { ++done; }), Stopped);
  EXPECT_LT(done, 1000);
}

TEST(SideBySide, ThrowsTheFirstFailureAtAnySpeed) {
  for (int round = 0; round < 200; ++round) {
    try {
      side_by_side(8, [](std::size_t i) {
        if (i > 0) throw std::out_of_range(std::to_string(i));
      });
      FAIL();
    } catch (const std::out_of_range& failure) {
      ASSERT_STREQ(failure.what(), "1");
    }
  }
}

}  // namespace
}  // namespace taut::stop_test
