// The controller of the direct method, by a stepper whose errors are known.
#include "sim/methods/direct/controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace taut::controller_test {
namespace {

using direct::Attempt;
using direct::Controller;
using direct::kNever;
using direct::StepOptions;

constexpr double kOrder = 4;

/// A step of h errs by `rate` h^4, where 1 is allowed.
struct Known : direct::Stepping {
  double rate = 1, longest = kNever;
  double stop = kNever;    // s, where steps have to end
  double solved = kNever;  // s: longer steps have no solution
  bool lands_there = true;
  std::vector<double> ends = {};  // s, of all steps that were taken

  double first_step() const override { return 0.01; }
  double longest_step(double) override { return longest; }
  double order() const override { return kOrder; }
  bool lands(double, double) const override { return lands_there; }
  Attempt attempt(double time, double h, double) override {
    Attempt made{h <= solved, rate * std::pow(h, kOrder), 1};
    if (time < stop && time + h > stop * (1 + 1e-12)) made.event = stop - time;
    return made;
  }
  void accept(double time) override { ends.push_back(time); }
  [[noreturn]] void give_up(double time) override {
    throw Diverged("known", time, 0, "", 0, "gave up");
  }
};

TEST(Controller, StepsAreAsLongAsTheirErrorAllows) {
  Known steps;
  steps.rate = 1e4;  // 0.1 s errs by what is allowed
  Controller controller{StepOptions{}};
  Counters counters;
  controller.follow(steps, 100, counters);
  EXPECT_EQ(controller.time(), 100);
  EXPECT_NEAR(static_cast<double>(counters.steps), 100 / 0.09, 5);
  EXPECT_EQ(counters.rejected, 0u);
  steps.rate *= 16;  // 0.05 s
  controller.follow(steps, 110, counters);
  EXPECT_EQ(counters.rejected, 1u);
  EXPECT_NEAR(controller.time() - controller.before(), 10 / std::ceil(10 / 0.045), 1e-9);
}

TEST(Controller, StepsLandInEqualPartsOrGoBeyond) {
  Known steps;
  steps.longest = 0.03;
  Controller controller{StepOptions{}};
  Counters counters;
  controller.follow(steps, 1, counters);
  EXPECT_EQ(steps.ends.back(), 1);
  EXPECT_NEAR(steps.ends.back() - steps.ends[steps.ends.size() - 2],
              steps.ends[steps.ends.size() - 2] - steps.ends[steps.ends.size() - 3], 1e-12);
  steps.lands_there = false;
  controller.follow(steps, 1.05, counters);
  EXPECT_NEAR(controller.time(), 1.06, 1e-12);
}

TEST(Controller, AStepEndsWhereSomethingChanges) {
  Known steps;
  steps.rate = 1e-9;
  steps.stop = 0.4321;
  Controller controller{StepOptions{}};
  Counters counters;
  controller.follow(steps, 1, counters);
  EXPECT_TRUE(std::ranges::any_of(steps.ends,
                                  [&](double end) { return std::abs(end - steps.stop) < 1e-12; }));
  EXPECT_EQ(counters.rejected, 1u);
}

TEST(Controller, FixedStepsStayOnTheirGridAndAreShorterWhereTheyFail) {
  Known steps;
  steps.lands_there = false;
  StepOptions fixed;
  fixed.step = 0.125;
  Controller controller{fixed};
  Counters counters;
  for (const double until : {0.1, 0.3, 0.9}) controller.follow(steps, until, counters);
  ASSERT_EQ(steps.ends.size(), 8u);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(steps.ends[k], 0.125 * double(k + 1));
  steps.solved = 0.05;
  controller.follow(steps, 2, counters);
  EXPECT_GT(counters.rejected, 0u);
  EXPECT_TRUE(std::ranges::find(steps.ends, 1.125) != steps.ends.end());
}

TEST(Controller, WhereNoStepIsShortEnoughOrAllAreTooShortItEnds) {
  Known steps;
  steps.solved = -1;
  Controller unsolved{StepOptions{}};
  Counters counters;
  EXPECT_THROW(unsolved.follow(steps, 1, counters), Diverged);
  EXPECT_LT(counters.steps, 100u);
  Known slow;
  slow.longest = 1e-11;
  Controller stalled{StepOptions{}};
  EXPECT_THROW(stalled.follow(slow, 1, counters), Diverged);
  EXPECT_LT(slow.ends.back(), 1e-7);
}

}  // namespace
}  // namespace taut::controller_test
