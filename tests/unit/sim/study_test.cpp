#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/study/speed_accuracy.h"

namespace taut::study_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

World swinging_rope(std::size_t particles) {
  World world;
  world.connectors = {
      straight_connector("rope", 0.2, 0.05, particles, Vec3::Zero(), Vec3(1, 0, 0))};
  world.connectors[0].holds = {{0, {}}};
  finish(world);
  return world;
}

MethodInfo made_up() {
  MethodInfo info;
  info.name = "made-up";
  SettingInfo step{.name = "step", .meaning = "", .unit = "s", .fallback = 0.001};
  step.sweep = {0.008, 0.004, 0.002, 0.001, 0.0005};
  SettingInfo solver{.name = "solver", .meaning = "", .unit = "", .fallback = std::string("a")};
  solver.sweep = {std::string("a"), std::string("b")};
  SettingInfo fixed{.name = "fixed", .meaning = "", .unit = "1", .fallback = 1.0};
  info.settings = {solver, fixed, step};
  return info;
}

TEST(Sweep, GoesThroughEveryCombinationOnce) {
  const std::vector<MethodChoice> all = study::sweep(made_up(), false);
  ASSERT_EQ(all.size(), 10u);
  EXPECT_EQ(describe(all[0]), "made-up (solver a, step 0.008)");
  EXPECT_EQ(describe(all[9]), "made-up (solver b, step 0.0005)");
  const std::vector<MethodChoice> thin = study::sweep(made_up(), true);
  ASSERT_EQ(thin.size(), 6u);
  EXPECT_EQ(describe(thin[1].settings), "solver a, step 0.002");
}

TEST(Sweep, LeavesAMethodWithoutValuesAtItsDefaults) {
  MethodInfo info = made_up();
  for (SettingInfo& setting : info.settings) setting.sweep.clear();
  const std::vector<MethodChoice> all = study::sweep(info, false);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(describe(all[0].settings), "defaults");
}

TEST(Front, HoldsWhatNothingBeatsInBoth) {
  const study::CostAndError points[] = {{3, 0.1}, {1, 1.0}, {2, 2.0},
                                        {2, 0.5}, {5, 0.1}, {0.5, kInfinity}};
  EXPECT_EQ(study::pareto_front(points), (std::vector<std::size_t>{1, 3, 0}));
  EXPECT_EQ(study::cheapest(points, 0.5), 3u);
  EXPECT_EQ(study::cheapest(points, 0.1), 0u);
  EXPECT_FALSE(study::cheapest(points, 0.01));
}

TEST(Front, CostOfAnErrorLiesBetweenItsNeighbours) {
  const std::vector<study::CostAndError> points{
      {1, 1e-1}, {50, 1}, {100, 1e-3}, {kInfinity, kInfinity}};
  EXPECT_DOUBLE_EQ(study::cost_at(points, 1e-1).value(), 1);
  EXPECT_NEAR(study::cost_at(points, 1e-2).value(), 10, 1e-9);
  EXPECT_DOUBLE_EQ(study::cost_at(points, 1e-3).value(), 100);
  EXPECT_FALSE(study::cost_at(points, 1e-4));
  EXPECT_DOUBLE_EQ(study::cost_at(points, 0.5).value(), 1);
  EXPECT_FALSE(study::cost_at({}, 1));
}

TEST(Front, SpreadIsMedianQuartilesAndEnds) {
  const study::Spread s = study::spread({4, 1, 3, 2, 5});
  EXPECT_EQ(s.least, 1);
  EXPECT_EQ(s.most, 5);
  EXPECT_EQ(s.low, 2);
  EXPECT_EQ(s.median, 3);
  EXPECT_EQ(s.high, 4);
  EXPECT_EQ(study::spread({1, 2}).median, 1.5);
  EXPECT_EQ(study::spread({}).median, 0);
}

TEST(Front, UnsteadinessIsTheMedianRowsLargestDistance) {
  std::vector<study::AccuracyRow> rows(4);
  rows[0].cpu = {1.0, 1.1, 0.98};  // 10%
  rows[1].cpu = {2.0, 2.0, 1.6};   // 20%
  rows[2].cpu = {1.0, 1.3, 1.0};   // 30%
  rows[3].cpu = {1.0, 9.0};        // too few
  EXPECT_DOUBLE_EQ(study::unsteadiness(rows), 0.2);
  EXPECT_EQ(study::unsteadiness(std::span(rows).last(1)), 0);
}

std::vector<Snapshot> two_frames(double shift) {
  std::vector<Snapshot> frames(2);
  for (int k = 0; k < 2; ++k) {
    frames[static_cast<std::size_t>(k)].time = k;
    frames[static_cast<std::size_t>(k)].connectors = {
        {Vec3(0, 0, 0), Vec3(1 + k * shift, 0, 0), Vec3(2, k * shift, 0)}};
  }
  return frames;
}

TEST(Accuracy, IsTheRootMeanSquareUpToTheHorizon) {
  const auto truth = two_frames(0), off = two_frames(0.3);
  const study::Metric metric = study::share_of_length(2);
  EXPECT_DOUBLE_EQ(study::rms_error(off, truth, 1, metric.distance), 0.15 * std::sqrt(2.0 / 6));
  EXPECT_EQ(study::rms_error(off, truth, 0.5, metric.distance), 0);
  EXPECT_DOUBLE_EQ(study::frame_error(off[1], truth[1], metric.distance),
                   0.15 * std::sqrt(2.0 / 3));
  EXPECT_EQ(study::rms_error(std::span(off).first(1), truth, 1, metric.distance), kInfinity);
}

TEST(Accuracy, SegmentDifferenceIsTheMeanOfMidpoints) {
  const auto truth = two_frames(0), off = two_frames(0.3);
  // Midpoints move by (0.15, 0) and (0.15, 0.15).
  EXPECT_DOUBLE_EQ(study::segment_difference(off[1], truth[1]), (0.15 + 0.15 * std::sqrt(2.0)) / 2);
}

TEST(Accuracy, RefusesAnotherWorld) {
  auto truth = two_frames(0), off = two_frames(0);
  off[1].connectors[0].pop_back();
  EXPECT_THROW(study::rms_error(off, truth, 1, study::share_of_length(1).distance),
               std::invalid_argument);
}

TEST(StudyRun, RecordsTheStatesThatTheSimulationPassesThrough) {
  const study::Problem problem{swinging_rope(11), study::frame_times(0.5, 60)};
  const MethodChoice candidate{"impulse", {{"step", 1.0 / 960}}};
  const auto result = study::run(problem, candidate, 10);
  ASSERT_EQ(result.end, study::Run::End::done);
  ASSERT_EQ(result.frames.size(), 31u);
  Simulation simulation(problem.world, make_method("impulse", candidate.settings));
  simulation.advance_to(0.5);
  EXPECT_EQ(result.frames.back().connectors[0], simulation.world().connectors[0].position);
  EXPECT_EQ(result.counters.steps, 480u);
  EXPECT_GT(result.cpu, 0);
}

TEST(StudyRun, FollowsPinsAndCuts) {
  study::Problem problem{swinging_rope(11), study::frame_times(0.5, 60)};
  problem.timeline.pins = {{0, 0.113, 0.1, 0.3, {}}};
  problem.timeline.cuts = {{0, 0.15, 0.4}};
  const MethodChoice candidate{"impulse", {{"step", 1.0 / 960}}};
  const auto result = study::run(problem, candidate, 10);
  ASSERT_EQ(result.end, study::Run::End::done);
  Simulation simulation(problem.world, make_method("impulse", candidate.settings),
                        problem.timeline);
  simulation.advance_to(0.5);
  EXPECT_EQ(result.frames.back().connectors, simulation.state().connectors);
  EXPECT_EQ(result.frames.back().connectors.size(), 2u);
  problem.timeline.pins[0].to.emplace().point = Vec3(9, 9, 9);  // out of reach when its time comes
  EXPECT_EQ(study::run(problem, candidate, 10).end, study::Run::End::diverged);
}

TEST(StudyRun, StopsAtItsCap) {
  const study::Problem problem{swinging_rope(101), study::frame_times(100, 1)};
  const auto result = study::run(problem, {"impulse", {{"step", 1e-5}}}, 0.05);
  EXPECT_EQ(result.end, study::Run::End::over_cap);
  EXPECT_LT(result.cpu, 0.5);
  EXPECT_LT(result.reached, 100);
}

TEST(StudyRun, FrameTimesHoldBothEnds) {
  const std::vector<double> times = study::frame_times(2, 60);
  ASSERT_EQ(times.size(), 121u);
  EXPECT_EQ(times.front(), 0);
  EXPECT_EQ(times.back(), 2);
}

}  // namespace
}  // namespace taut::study_test
