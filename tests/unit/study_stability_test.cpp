#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sim/measure/measure.h"
#include "sim/study/bench.h"
#include "sim/study/speed_accuracy.h"
#include "sim/study/stability.h"

namespace taut {
namespace {

constexpr double kGravity = 9.81;

/// A rope of 0.2 m and 50 g from the origin along `direction`, 200 g at its end.
Problem rope(const Vec3& direction, double duration = 0.5) {
  World world;
  world.connectors = {straight_connector("rope", 0.2, 0.05, 11, Vec3::Zero(), direction)};
  world.connectors[0].particle_mass.back() += 0.2;
  world.connectors[0].holds = {{0, {}}};
  finish(world);
  return {world, frame_times(duration, 60)};
}

TEST(Stability, AvailableEnergyIsTheFallToHangingStraight) {
  // A chain of equal particles has its centre in the middle, whatever their number.
  const double whole = kGravity * (0.2 * 0.2 + 0.05 * 0.1);
  EXPECT_NEAR(available_energy(rope(Vec3(1, 0, 0)).world), whole, 1e-12);
  EXPECT_NEAR(available_energy(rope(Vec3(0, 1, 0)).world), 2 * whole, 1e-12);
  // Hanging at rest nothing is available; the scale is a thousandth of a fall by the length then.
  EXPECT_NEAR(available_energy(rope(Vec3(0, -1, 0)).world),
              1e-3 * kGravity * 0.2 * (0.25 - 0.05 / 11), 1e-12);
}

TEST(Stability, AvailableEnergyOfFreeFlightIsItsMotion) {
  Problem problem = rope(Vec3(1, 0, 0));
  problem.world.connectors[0].holds.clear();
  problem.world.gravity.setZero();
  for (Vec3& velocity : problem.world.connectors[0].velocity) velocity = Vec3(0, 2, 0);
  EXPECT_NEAR(available_energy(problem.world), 0.25 * 4 / 2, 1e-12);
}

TEST(Stability, FirstVerdictThatFitsWins) {
  const Problem problem = rope(Vec3(1, 0, 0));
  const double scale = available_energy(problem.world);
  ::taut::Run run;
  EXPECT_EQ(classify(problem, run, nullptr).motion_class, MotionClass::plausible);
  run.energy_loss = 0.11 * scale;
  EXPECT_EQ(classify(problem, run, nullptr).motion_class, MotionClass::over_damped);
  run.stretch_max = 0.011;
  EXPECT_EQ(classify(problem, run, nullptr).motion_class, MotionClass::stretched);
  run.energy_gain = 0.11 * scale;
  EXPECT_EQ(classify(problem, run, nullptr).motion_class, MotionClass::failed);
  run = {};
  run.end = ::taut::Run::End::over_cap;
  EXPECT_EQ(classify(problem, run, nullptr).motion_class, MotionClass::over_cap);
  run.end = ::taut::Run::End::diverged;
  EXPECT_EQ(classify(problem, run, nullptr).motion_class, MotionClass::failed);
}

TEST(Stability, AccurateNeedsAReference) {
  const Problem problem = rope(Vec3(1, 0, 0));
  const ::taut::Run run = ::taut::run(problem, {"impulse", {}}, 10);
  const Reference itself{run.frames, 0.5, 0};
  const Classification same = classify(problem, run, &itself);
  EXPECT_EQ(same.error, 0);
  EXPECT_TRUE(std::isnan(classify(problem, run, nullptr).error));
  ::taut::Run cut = run;
  cut.frames.resize(5);
  EXPECT_TRUE(std::isinf(classify(problem, cut, &itself).error));
}

TEST(Stability, EnergyOfADrivenWorldIsNotJudged) {
  Problem problem = rope(Vec3(1, 0, 0));
  ::taut::Run run;
  run.energy_gain = 1e6;
  const auto verdict_on = [&](std::vector<PathKey> keys) {
    Attachment& hold = problem.world.connectors[0].holds[0].to;
    hold.kind = Attachment::Kind::path;
    hold.path = std::make_shared<const Path>(std::move(keys));
    return classify(problem, run, nullptr).motion_class;
  };
  EXPECT_EQ(verdict_on({{0, Vec3::Zero()}}), MotionClass::failed)
      << "a path of one key moves nothing";
  EXPECT_EQ(verdict_on({{0, Vec3::Zero()}, {1, Vec3::UnitX()}}), MotionClass::plausible);
}

TEST(Stability, AvailableEnergyOfAMasslessSpanIsThatOfItsEnds) {
  World world = rope(Vec3(1, 0, 0)).world;
  world.connectors[0].model = ConnectorModel::span;
  EXPECT_NEAR(available_energy(world), kGravity * 0.2 * (0.2 + 0.05 / 11), 1e-12);
}

/// A ball that hangs by a joint of no length, 0.3 m below it.
Problem ball_on_a_joint() {
  World world;
  Body ball;
  ball.mass_properties = solid_sphere(2, 0.2);
  ball.position = Vec3(0, -0.3, 0);
  world.bodies = {ball};
  Connector joint = straight_connector("joint", 0, 0, 2, Vec3::Zero(), Vec3::UnitX());
  joint.holds = {{0, {}}, {1, {Attachment::Kind::body, Vec3(0, 0.3, 0), nullptr, 0}}};
  world.connectors = {joint};
  finish(world);
  return {world, frame_times(0.1, 60)};
}

TEST(Stability, AWorldOfJointsAloneHasALength) {
  const Problem problem = ball_on_a_joint();
  // The mean square distance of a ball's mass from its centre is 3/5 of its radius squared.
  const double length = std::sqrt(0.3 * 0.3 + 0.6 * 0.1 * 0.1);
  EXPECT_NEAR(total_length(problem.world), length, 1e-15);
  EXPECT_NEAR(energy_scale(problem.world), 2 * kGravity * length, 1e-12);
  EXPECT_NEAR(available_energy(problem.world), 1e-3 * 2 * kGravity * length, 1e-12);
  const ::taut::Run run = ::taut::run(problem, {"direct", {}}, 10);
  const Reference itself{run.frames, 0.1, 0};
  EXPECT_EQ(classify(problem, run, &itself).motion_class, MotionClass::accurate);
}

TEST(Stability, AWorldThatNothingCanMoveIsJudged) {
  Problem problem = ball_on_a_joint();
  problem.world.gravity.setZero();
  const Classification classification = classify(problem, {}, nullptr);
  EXPECT_EQ(classification.gain, 0);
  EXPECT_EQ(classification.loss, 0);
}

TEST(SpeedAccuracy, ScoresAgainstTheReference) {
  const Problem problem = rope(Vec3(1, 0, 0));
  const Candidate fine{"impulse", {{"step", 1.0 / 3840}}}, coarse{"impulse", {{"step", 1.0 / 240}}};
  const Reference reference{run(problem, fine, 10).frames, 0.5, 0};
  const Metric metrics[] = {share_of_length(0.2)};
  AccuracyRow row = score(problem, reference, metrics, fine, 10);
  EXPECT_EQ(row.errors.at(0), 0);
  EXPECT_NEAR(row.steps, 3840, 1e-6);
  EXPECT_EQ(row.cpu.size(), 1u);
  add_timing(problem, row);
  EXPECT_EQ(row.cpu.size(), 2u);
  EXPECT_GT(score(problem, reference, metrics, coarse, 10).errors.at(0), 0);
}

TEST(SpeedAccuracy, ARunThatEndsEarlyHasNoCost) {
  const Problem problem = rope(Vec3(1, 0, 0), 100);
  const Metric metrics[] = {share_of_length(0.2)};
  const AccuracyRow row =
      score(problem, {{}, 100, 0}, metrics, {"impulse", {{"step", 1e-5}}}, 0.02);
  EXPECT_EQ(row.end, ::taut::Run::End::over_cap);
  EXPECT_TRUE(row.cpu.empty());
  const CostAndError point = cost_and_error(std::span(&row, 1), 0).at(0);
  EXPECT_TRUE(std::isinf(point.cost));
  EXPECT_TRUE(std::isinf(point.error));
}

TEST(Bench, TimesEveryFrameOfEveryRepeat) {
  const Problem problem = rope(Vec3(1, 0, 0));
  const Candidate candidates[] = {{"impulse", {{"step", 1.0 / 960}}},
                                  {"impulse", {{"step", 1.0 / 15360}}}};
  int pauses = 0;
  BenchOptions options{.repeats = 3, .seconds = 60, .pause = [&] { ++pauses; }};
  const std::vector<BenchRow> rows = bench(problem, candidates, options);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(pauses, 6);
  for (const BenchRow& row : rows) {
    EXPECT_EQ(row.frames.size(), problem.times.size());
    EXPECT_EQ(row.repeats, 3u);
    EXPECT_LE(row.mean.low, row.mean.median);
  }
  EXPECT_GT(rows[1].mean.median, 4 * rows[0].mean.median);  // sixteen times the steps
}

}  // namespace
}  // namespace taut
