// The six phases of the paper's Figure 7, proved from the routine's trajectory where its captions
// say that they are.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/physics/character/routine.h"

namespace taut::routine_phases_test {
namespace {

const Routine& routine() {
  return Routine::paper();
}
std::vector<Instance> during(std::string_view phase) {
  const scenes::Caption& caption = routine().caption(phase);
  return routine().between(caption.from, caption.until);
}
constexpr double kSlack = 1e-4;             // m below the chain's length
constexpr double kFrameOfFall = 9.81 / 60;  // m/s: captions are true to a frame

/// The largest part by which free fall is missed between two instances, of gravity.
double off_free_fall(const std::vector<Instance>& fall) {
  double largest = 0;
  // Rates over 20 ms, so that rounding does not count.
  const auto apart = static_cast<std::size_t>(0.02 / routine().step);
  for (std::size_t i = 0; i + apart < fall.size(); ++i) {
    const Vec3 gained = fall[i + apart].velocity - fall[i].velocity;
    const double time = fall[i + apart].time - fall[i].time;
    const Vec3& g = routine().scene.world.gravity;
    largest = std::max(largest, (gained / time - g).norm() / g.norm());
  }
  return largest;
}

TEST(RoutinePhases, EachButTheImpulseLastsLongEnough) {
  double before = 0;
  for (const char* phase : {"a", "b", "c", "d", "f"}) {
    const scenes::Caption& caption = routine().caption(phase);
    EXPECT_GE(caption.from, before) << phase;
    EXPECT_GE(caption.until - caption.from, 0.15 - 1e-9) << phase;
    before = caption.until;
  }
}

TEST(RoutinePhases, TheHandSwingsAndTheFreeStickMovesFreely) {
  double fastest = 0, low = 1, high = -1;
  for (const Instance& i : during("a")) {
    fastest = std::max(fastest, i.hand.velocity.norm());
    low = std::min(low, (i.position - i.from).z());
    high = std::max(high, (i.position - i.from).z());
  }
  EXPECT_GT(fastest, 1);  // m/s
  EXPECT_GT(high - low, 0.2);
}

TEST(RoutinePhases, TheHandStops) {
  const auto stop = during("b");
  EXPECT_GT(stop.front().hand.velocity.norm(), 1);
  EXPECT_LT(stop.back().hand.velocity.norm(), 1e-9);
}

TEST(RoutinePhases, TheFreeStickRisesThoughTheHandRests) {
  for (const Instance& i : during("c")) {
    EXPECT_LT(i.hand.velocity.norm(), 1e-9) << i.time;
    EXPECT_GT(i.velocity.y(), -kFrameOfFall) << i.time;
  }
  const double rest = routine().rest(routine().caption("b"));
  const double until = routine().caption("d").until;
  const auto after = routine().between(rest, until);
  double top = after.front().position.y();
  for (const Instance& i : after) top = std::max(top, i.position.y());
  EXPECT_GE(top - after.front().position.y(), 0.1);
}

TEST(RoutinePhases, ItFallsFreelyWhileTheChainIsSlack) {
  for (const char* phase : {"c", "d", "f"}) {
    const auto fall = during(phase);
    for (const Instance& i : fall)
      EXPECT_LT(i.span(), routine().length - kSlack) << phase << " at " << i.time;
    EXPECT_LT(off_free_fall(fall), 0.01) << phase;
  }
  for (const Instance& i : during("d")) EXPECT_LT(i.velocity.y(), kFrameOfFall) << i.time;
}

/// The impulse is the jump of the free stick's momentum in the step in which it is.
TEST(RoutinePhases, TheChainGoesTautWithAnImpulse) {
  const scenes::Caption& caption = routine().caption("e");
  int impulses = 0;
  double largest = 0;
  for (const Event& event : routine().events) {
    if (event.kind != Event::Kind::impulse || event.time < caption.from - 0.01 ||
        event.time > caption.until)
      continue;
    if (impulses++ == 0) {
      EXPECT_NEAR(event.time, caption.from, 0.01);
    }
    // Gravity's part of a step is 0.6 mN s; the pull that keeps the chain taut afterwards, m v^2/r
    // of a stick that turns at 3 m/s, is up to 2 mN s.
    const auto step = static_cast<std::size_t>(event.time / routine().step);
    const Instance &before = routine().steps.at(step - 1), &after = routine().steps.at(step);
    const Vec3 fall = routine().scene.world.gravity * routine().step;
    const double jump = routine().mass * (after.velocity - before.velocity - fall).norm();
    EXPECT_NEAR(jump, event.size, 3e-3) << event.time;
    largest = std::max(largest, event.size);
  }
  EXPECT_GE(impulses, 1);
  EXPECT_GT(largest, 0.1);  // N s: 0.12 kg stopped from about 1 m/s and more
}

TEST(RoutinePhases, TheHandMovesAgainWhileTheStickFallsFreely) {
  double way = 0;
  const auto fall = during("f");
  for (std::size_t i = 1; i < fall.size(); ++i)
    way += (fall[i].hand.position - fall[i - 1].hand.position).norm();
  EXPECT_GT(way / (fall.back().time - fall.front().time), 0.5);  // m/s
}

}  // namespace
}  // namespace taut::routine_phases_test
