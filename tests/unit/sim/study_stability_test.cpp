#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sim/measure/measure.h"
#include "sim/study/speed_accuracy.h"
#include "sim/study/stability.h"

namespace taut::study_stability_test {
namespace {

constexpr double kGravity = 9.81;

/// A rope of 0.2 m and 50 g from the origin along `direction`, 200 g at its end.
study::Problem rope(const Vec3& direction, double duration = 0.5) {
  World world;
  world.connectors = {straight_connector("rope", 0.2, 0.05, 11, Vec3::Zero(), direction)};
  world.connectors[0].particle_mass.back() += 0.2;
  world.connectors[0].holds = {{0, {}}};
  finish(world);
  return {world, study::frame_times(duration, 60)};
}

TEST(Stability, AvailableEnergyIsTheFallToHangingStraight) {
  // A chain of equal particles has its centre in the middle, whatever their number.
  const double whole = kGravity * (0.2 * 0.2 + 0.05 * 0.1);
  EXPECT_NEAR(study::available_energy(rope(Vec3(1, 0, 0)).world), whole, 1e-12);
  EXPECT_NEAR(study::available_energy(rope(Vec3(0, 1, 0)).world), 2 * whole, 1e-12);
  // Hanging at rest nothing is available; the scale is a thousandth of a fall by the length then.
  EXPECT_NEAR(study::available_energy(rope(Vec3(0, -1, 0)).world),
              1e-3 * kGravity * 0.2 * (0.25 - 0.05 / 11), 1e-12);
}

TEST(Stability, AvailableEnergyOfFreeFlightIsItsMotion) {
  study::Problem problem = rope(Vec3(1, 0, 0));
  problem.world.connectors[0].holds.clear();
  problem.world.gravity.setZero();
  for (Vec3& velocity : problem.world.connectors[0].velocity) velocity = Vec3(0, 2, 0);
  EXPECT_NEAR(study::available_energy(problem.world), 0.25 * 4 / 2, 1e-12);
}

TEST(Stability, FirstClassThatFitsWins) {
  const study::Problem problem = rope(Vec3(1, 0, 0));
  const double scale = study::available_energy(problem.world);
  study::Run run;
  EXPECT_EQ(study::classify(problem, run, nullptr).motion_class, study::MotionClass::plausible);
  run.energy_loss = 0.11 * scale;
  EXPECT_EQ(study::classify(problem, run, nullptr).motion_class, study::MotionClass::over_damped);
  run.stretch_max = 0.011;
  EXPECT_EQ(study::classify(problem, run, nullptr).motion_class, study::MotionClass::stretched);
  run.energy_gain = 0.11 * scale;
  EXPECT_EQ(study::classify(problem, run, nullptr).motion_class, study::MotionClass::failed);
  run = {};
  run.end = study::Run::End::over_cap;
  EXPECT_EQ(study::classify(problem, run, nullptr).motion_class, study::MotionClass::over_cap);
  run.end = study::Run::End::diverged;
  EXPECT_EQ(study::classify(problem, run, nullptr).motion_class, study::MotionClass::failed);
}

TEST(Stability, AccurateNeedsAReference) {
  const study::Problem problem = rope(Vec3(1, 0, 0));
  const study::Run run = study::run(problem, {"impulse", {}}, 10);
  const truth::Reference itself{run.frames, 0.5, 0};
  const study::Classification same = study::classify(problem, run, &itself);
  EXPECT_EQ(same.error, 0);
  EXPECT_TRUE(std::isnan(study::classify(problem, run, nullptr).error));
  study::Run cut = run;
  cut.frames.resize(5);
  EXPECT_TRUE(std::isinf(study::classify(problem, cut, &itself).error));
}

TEST(Stability, EnergyOfADrivenWorldIsNotJudged) {
  study::Problem problem = rope(Vec3(1, 0, 0));
  study::Run run;
  run.energy_gain = 1e6;
  const auto class_on = [&](std::vector<PathKey> keys) {
    Attachment& hold = problem.world.connectors[0].holds[0].to;
    hold.kind = Attachment::Kind::path;
    hold.path = std::make_shared<const Path>(std::move(keys));
    return study::classify(problem, run, nullptr).motion_class;
  };
  EXPECT_EQ(class_on({{0, Vec3::Zero()}}), study::MotionClass::failed)
      << "a path of one key moves nothing";
  EXPECT_EQ(class_on({{0, Vec3::Zero()}, {1, Vec3::UnitX()}}), study::MotionClass::plausible);
}

TEST(Stability, AvailableEnergyOfAMasslessSpanIsThatOfItsEnds) {
  World world = rope(Vec3(1, 0, 0)).world;
  world.connectors[0].model = ConnectorModel::span;
  EXPECT_NEAR(study::available_energy(world), kGravity * 0.2 * (0.2 + 0.05 / 11), 1e-12);
}

/// A ball that hangs by a joint of no length, 0.3 m below it.
study::Problem ball_on_a_joint() {
  World world;
  Body ball;
  ball.mass_properties = solid_sphere(2, 0.2);
  ball.position = Vec3(0, -0.3, 0);
  world.bodies = {ball};
  Connector joint = straight_connector("joint", 0, 0, 2, Vec3::Zero(), Vec3::UnitX());
  joint.holds = {{0, {}}, {1, {Attachment::Kind::body, Vec3(0, 0.3, 0), nullptr, 0}}};
  world.connectors = {joint};
  finish(world);
  return {world, study::frame_times(0.1, 60)};
}

TEST(Stability, AWorldOfJointsAloneHasALength) {
  const study::Problem problem = ball_on_a_joint();
  // The mean square distance of a ball's mass from its centre is 3/5 of its radius squared.
  const double length = std::sqrt(0.3 * 0.3 + 0.6 * 0.1 * 0.1);
  EXPECT_NEAR(study::total_length(problem.world), length, 1e-15);
  EXPECT_NEAR(energy_scale(problem.world), 2 * kGravity * length, 1e-12);
  EXPECT_NEAR(study::available_energy(problem.world), 1e-3 * 2 * kGravity * length, 1e-12);
  const study::Run run = study::run(problem, {"direct", {}}, 10);
  const truth::Reference itself{run.frames, 0.1, 0};
  EXPECT_EQ(study::classify(problem, run, &itself).motion_class, study::MotionClass::accurate);
}

TEST(Stability, AWorldThatNothingCanMoveIsJudged) {
  study::Problem problem = ball_on_a_joint();
  problem.world.gravity.setZero();
  const study::Classification classification = study::classify(problem, {}, nullptr);
  EXPECT_EQ(classification.gain, 0);
  EXPECT_EQ(classification.loss, 0);
}

TEST(SpeedAccuracy, ScoresAgainstTheReference) {
  const study::Problem problem = rope(Vec3(1, 0, 0));
  const MethodChoice fine{"impulse", {{"step", 1.0 / 3840}}},
      coarse{"impulse", {{"step", 1.0 / 240}}};
  const truth::Reference reference{run(problem, fine, 10).frames, 0.5, 0};
  const study::Metric metrics[] = {study::share_of_length(0.2)};
  study::AccuracyRow row = study::score(problem, reference, metrics, fine, 10);
  EXPECT_EQ(row.errors.at(0), 0);
  EXPECT_NEAR(row.steps, 3840, 1e-6);
  EXPECT_EQ(row.cpu.size(), 1u);
  study::add_timing(problem, row);
  EXPECT_EQ(row.cpu.size(), 2u);
  EXPECT_GT(study::score(problem, reference, metrics, coarse, 10).errors.at(0), 0);
}

TEST(SpeedAccuracy, ARunThatEndsEarlyHasNoCost) {
  const study::Problem problem = rope(Vec3(1, 0, 0), 100);
  const study::Metric metrics[] = {study::share_of_length(0.2)};
  const study::AccuracyRow row =
      study::score(problem, {{}, 100, 0}, metrics, {"impulse", {{"step", 1e-5}}}, 0.02);
  EXPECT_EQ(row.end, study::Run::End::over_cap);
  EXPECT_TRUE(row.cpu.empty());
  const study::CostAndError point = study::cost_and_error(std::span(&row, 1), 0).at(0);
  EXPECT_TRUE(std::isinf(point.cost));
  EXPECT_TRUE(std::isinf(point.error));
}

TEST(Bench, TimesEveryFrameOfEveryRepeat) {
  const study::Problem problem = rope(Vec3(1, 0, 0));
  const MethodChoice candidates[] = {{"impulse", {{"step", 1.0 / 960}}},
                                     {"impulse", {{"step", 1.0 / 15360}}}};
  int pauses = 0;
  study::BenchOptions options{.repeats = 3, .seconds = 60, .pause = [&] { ++pauses; }};
  const std::vector<study::BenchRow> rows = study::bench(problem, candidates, options);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(pauses, 6);
  for (const study::BenchRow& row : rows) {
    EXPECT_EQ(row.frames.size(), problem.times.size());
    EXPECT_EQ(row.repeats, 3u);
    EXPECT_LE(row.mean.low, row.mean.median);
  }
  EXPECT_GT(rows[1].mean.median, 4 * rows[0].mean.median);  // sixteen times the steps
}

}  // namespace
}  // namespace taut::study_stability_test
