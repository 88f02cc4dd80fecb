// The figure-eight, the spin, the throw over the shoulder and the catch; none of it luck: at
// another tolerance the same comes of it.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/contact/capsule.h"
#include "sim/run/simulation.h"
#include "sim/run/trajectory.h"
#include "tests/physics/character/routine.h"

namespace taut::routine_play_test {
namespace {

const Routine& routine() {
  return Routine::shipped();
}
std::vector<Instance> during(std::string_view part) {
  const scenes::Caption& caption = routine().caption(part);
  return routine().between(caption.from, caption.until);
}

/// Signed areas (m^2, counterclockwise as the viewer sees them) of the loops that the stick's tip
/// draws in the frontal plane, left and right of a vertical line by turns; whole loops alone.
std::vector<double> loops(const std::vector<Instance>& moves, double line) {
  std::vector<double> areas;
  double area = 0;
  bool whole = false;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const Vec3 a = moves[i - 1].tip, b = moves[i].tip;
    if ((a.x() < line) != (b.x() < line)) {
      if (whole) areas.push_back(area);
      whole = true;
      area = 0;
    }
    // The loop is closed along the line, on which the first term vanishes.
    area += ((a.x() + b.x()) / 2 - line) * (b.y() - a.y());
  }
  return areas;
}

TEST(RoutinePlay, TheTipDrawsFigureEights) {
  const auto moves = during("Figure-eight");
  double line = 0, left = 0, right = 0;
  for (const Instance& i : moves) line += i.tip.x() / static_cast<double>(moves.size());
  const std::vector<double> areas = loops(moves, line);
  ASSERT_GE(areas.size(), 3u);
  for (std::size_t i = 0; i < areas.size(); ++i) {
    EXPECT_GT(std::abs(areas[i]), 0.02) << i;
    if (i > 0) {
      EXPECT_LT(areas[i] * areas[i - 1], 0) << "the sense of turning changes from side to side";
    }
  }
  for (const Instance& i : moves) {
    left = std::min(left, i.hand.position.x() - line);
    right = std::max(right, i.hand.position.x() - line);
  }
  EXPECT_LT(left, -0.1);
  EXPECT_GT(right, 0.1);
}

TEST(RoutinePlay, TheSpinTurnsOneWay) {
  double turned = 0, before = 0;
  bool first = true;
  for (const Instance& i : during("Spin")) {
    const Vec3 stick = i.tip - i.from;
    const double angle = std::atan2(stick.y(), stick.x());
    const double turn = first ? 0 : std::remainder(angle - before, 2 * M_PI);
    EXPECT_GE(turn, 0) << i.time;
    turned += turn;
    before = angle;
    first = false;
  }
  EXPECT_GT(turned, 2 * 2 * M_PI);
}

TEST(RoutinePlay, TheChainStaysTautInIt) {
  for (const char* part : {"Figure-eight", "Spin"})
    for (const Instance& i : during(part)) EXPECT_GT(i.span(), routine().length - 1e-4) << i.time;
}

/// The stick goes over the shoulder and is caught: it hangs on the chain against trunk and arm,
/// behind him, and sways a little.
void expect_caught(const Routine& played) {
  const Instance& end = played.steps.back();
  EXPECT_LT(end.velocity.norm(), 0.5);  // m/s; he breathes
  EXPECT_LT(end.hand.velocity.norm(), 1e-9);
  EXPECT_LT(end.position.z(), end.hand.position.z() - 0.2);
  EXPECT_GT(end.top.y(), end.tip.y());
  EXPECT_GT(end.span(), 0.9 * played.length);
  const Body& stick = played.scene.world.bodies[1];
  for (const Obstacle& obstacle : played.scene.world.obstacles) {
    if (obstacle.name != "trunk" && obstacle.name != "upper_arm") continue;
    double least = 1;  // m, in the last second
    for (const Instance& at : played.between(end.time - 1, end.time)) {
      const contact::Capsule wood{at.top, at.tip, stick.capsule.radius};
      const Pose frame = obstacle.frame(at.time).pose();
      least = std::min(least, contact::least_gap(obstacle.shape, frame, wood));
    }
    EXPECT_LT(least, 1e-3) << obstacle.name;
  }
}

TEST(RoutinePlay, IsCaughtBehindTheShoulder) {
  double highest = 0;
  for (const Instance& i : routine().steps) highest = std::max(highest, i.tip.y());
  EXPECT_GT(highest, 1.7);  // m: over the head's height
  expect_caught(routine());
}

/// The limits of an arm: 6 m/s and 120 m/s^2 are far below a trained punch.
TEST(RoutinePlay, TheHandMovesAsAPersonCan) {
  for (const Routine* played : {&routine(), &Routine::paper()})
    for (const Instance& i : played->steps) {
      EXPECT_LT(i.hand.velocity.norm(), 6) << i.time;
      EXPECT_LT(i.hand.acceleration.norm(), 120) << i.time;
    }
}

/// Until it is thrown another tolerance hardly moves the stick; and it is caught all the same.
TEST(LongRoutinePlay, IsNotLuck) {
  const Routine fine = Routine::play("nunchaku.toml", true, {{"tolerance", 3e-4}});
  double off = 0;
  for (std::size_t k = 0; k < routine().steps.size(); ++k) {
    if (routine().steps[k].time > routine().caption("Four times slower: the hand").until) break;
    off = std::max(off, (routine().steps[k].tip - fine.steps.at(k).tip).norm());
  }
  EXPECT_LT(off, 0.005);  // m; the body is 20 mm away and more
  expect_caught(fine);
}

TEST(RoutinePlay, ThePapersIsNotLuck) {
  const Routine& paper = Routine::paper();
  const Routine fine =
      Routine::play("nunchaku_paper.toml", false, {{"step", paper.step / 2}, {"passes", 8.0}});
  double off = 0;
  for (std::size_t k = 0; k < paper.steps.size(); ++k)
    off = std::max(off, (paper.steps[k].tip - fine.steps.at(2 * k + 1).tip).norm());
  EXPECT_LT(off, 0.005);  // m; the body is 30 mm away and more
}

TEST(LongRoutinePlay, HasTheSameBitsTwice) {
  const auto hash = [] {
    const scenes::Scene& scene = routine().scene;
    Simulation simulation(scene.world, make_method(scene.method.name, scene.method.settings));
    for (int k = 1; k <= scene.frames(); ++k) simulation.advance_to(double(k) / scene.fps);
    return state_hash(simulation.world());
  };
  EXPECT_EQ(hash(), hash());
}

}  // namespace
}  // namespace taut::routine_play_test
