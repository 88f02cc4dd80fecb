// Error estimates against errors: of motions with known answers, and against the truth.
#include "sim/run/error_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/physics/worlds.h"

namespace taut::error_estimate_test {
namespace {

using worlds::kGravity;

std::vector<Vec3> particles(const World& world) {
  std::vector<Vec3> particles;
  for (const Connector& connector : world.connectors) {
    particles.insert(particles.end(), connector.position.begin(), connector.position.end());
  }
  return particles;
}

double distance(const World& a, const World& b) {
  const std::vector<Vec3> at = particles(a), should = particles(b);
  EXPECT_EQ(at.size(), should.size());
  double squares = 0;
  for (std::size_t i = 0; i < at.size(); ++i) squares += (at[i] - should[i]).squaredNorm();
  return std::sqrt(squares / static_cast<double>(at.size()));
}

struct Case {
  const char* name = "";
  World world;
  const char* method = "";
  Settings settings;
  double duration = 0.5;  // s
  Timeline timeline = {};
  /// The method solved far more finely, where that is not the truth; the truth where it is empty.
  Settings exact = {};
};

void PrintTo(const Case& row, std::ostream* out) {
  *out << row.name;
}

struct Frame {
  double time = 0;             // s
  double error = 0, told = 0;  // m
};

/// Sixty frames a second of a case: its error and what is told of it.
std::vector<Frame> frames(const Case& row) {
  const bool truth = row.exact.empty();
  Simulation exact(row.world, make_method(truth ? "truth" : row.method, row.exact), row.timeline);
  Simulation simulation(row.world, make_method(row.method, row.settings), row.timeline);
  ErrorEstimate estimate(row.world, row.method, row.settings, row.timeline);
  EXPECT_EQ(estimate.none(), "");
  std::vector<Frame> frames;
  for (int k = 0; k <= std::lround(60 * row.duration); ++k) {
    const double time = k / 60.0;
    exact.advance_to(time);
    simulation.advance_to(time);
    estimate.follow(simulation);
    frames.push_back({time, distance(simulation.world(), exact.world()), estimate.error()});
  }
  return frames;
}

std::string text(const char* words) {
  return words;
}

/// A chain that swings down from the side, eleven particles.
World swing() {
  return worlds::chain(11, 1, worlds::from_down(60));
}

/// A pin catches it, draws it nearer to where it hangs and lets it go; then it is cut.
Timeline caught_and_cut() {
  Timeline timeline;
  TimedPin pin;
  pin.along = 0.55;
  pin.from = 0.1;
  pin.until = 0.3;
  pin.to = worlds::fixed_at(0.4 * worlds::from_down(50));
  pin.over = 0.1;
  timeline.pins = {pin};
  timeline.cuts = {{.along = 0.75, .time = 0.4}};
  return timeline;
}

std::vector<Case> cases() {
  const Settings rk4{{"step", 1.0 / 480}, {"time_constant", 0.02}};
  const Settings finer{{"step", 1.0 / 1920}, {"time_constant", 0.005}};
  const Settings euler{
      {"step", 1.0 / 1920}, {"time_constant", 0.02}, {"integrator", text("semi-implicit-euler")}};
  const auto spring = [](double step, const char* integrator) {
    return Settings{{"step", step}, {"integrator", text(integrator)}, {"stiffness", 1e3}};
  };
  return {
      {"SwingByRungeKutta", swing(), "dynamic-constraints", rk4},
      {"SwingByEuler", swing(), "dynamic-constraints", euler},
      {"SwingOfOpenSteps", swing(), "dynamic-constraints", {}},
      {"SwingBySmallSteps", swing(), "xpbd", {{"step", 1.0 / 3840}}},
      {"SwingOfSprings",
       swing(),
       "springs",
       spring(1.0 / 3840, "semi-implicit-euler"),
       0.5,
       {},
       spring(1.0 / 61440, "rk4")},
      {"SwingOfSpringsByRungeKutta",
       swing(),
       "springs",
       spring(1.0 / 960, "rk4"),
       0.5,
       {},
       spring(1.0 / 61440, "rk4")},
      {"SwingOfLongSteps", swing(), "direct", {{"step", 1.0 / 60}}},
      {"SwingToACentimetre", swing(), "direct", {{"tolerance", 1e-2}}},
      {"SwingToATenthOfAMillimetre", swing(), "direct", {{"tolerance", 1e-4}}},
      {"SwingToAMicrometre", swing(), "direct", {{"tolerance", 1e-6}}},
      {"DrivenToATenthOfAMillimetre", worlds::driven_chain(9), "direct", {{"tolerance", 1e-4}}},
      {"ThrownToATenthOfAMillimetre", worlds::thrown(9), "direct", {{"tolerance", 1e-4}}},
      {"BodyToATenthOfAMillimetre", worlds::chain_with_box(9), "direct", {{"tolerance", 1e-4}}},
      {"CaughtAndCutToATenthOfAMillimetre",
       swing(),
       "direct",
       {{"tolerance", 1e-4}},
       0.5,
       caught_and_cut()},
      {"SwingInJointCoordinates", swing(), "multibody", {{"accuracy", 1e-5}}},
      {"SwingOfTheTruth", swing(), "truth", {{"local_error", 1e-8}}},
      {"BodyByRungeKutta", worlds::chain_with_box(9), "dynamic-constraints", rk4},
      {"DrivenByRungeKutta", worlds::driven_chain(9), "dynamic-constraints", rk4},
      {"ThrownByRungeKutta", worlds::thrown(9), "dynamic-constraints", rk4},
      {"CaughtAndCutByRungeKutta", swing(), "dynamic-constraints", finer, 0.5, caught_and_cut()},
  };
}

class Estimates : public testing::TestWithParam<Case> {};

TEST_P(Estimates, AreWithinAFactorOfThree) {
  double before = 0;
  int compared = 0;
  for (const Frame& frame : frames(GetParam())) {
    if (frame.told == before) continue;  // not compared with the coarser one
    before = frame.told;
    ++compared;
    EXPECT_LT(frame.told, 3 * frame.error) << frame.time;
    EXPECT_GT(frame.told, frame.error / 3) << frame.time;
  }
  EXPECT_GE(compared, 7);  // steps of a frame are compared every fourth of thirty frames
}

INSTANTIATE_TEST_SUITE_P(Known, Estimates, testing::ValuesIn(cases()),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(Estimate, OfAPendulumIsItsErrorByTheEllipticPeriod) {
  const double length = 0.5, degrees = 90;
  const double quarter =
      worlds::period_ratio(degrees) * std::numbers::pi / 2 * std::sqrt(length / kGravity);  // s
  const World world = worlds::pendulum(length, degrees);
  const Settings settings{{"step", quarter / 64}, {"time_constant", quarter / 8}};
  Simulation simulation(world, make_method("dynamic-constraints", settings));
  ErrorEstimate estimate(world, "dynamic-constraints", settings);
  for (int k = 0; k <= 80; ++k) {
    simulation.advance_to(k * quarter / 16);
    estimate.follow(simulation);
    if (k % 32 != 16) continue;  // on its way through the lowest place
    const Vec3& bob = simulation.world().connectors[0].position[1];
    const double error = (bob - Vec3(0, -length, 0)).norm() / std::numbers::sqrt2;
    EXPECT_LT(estimate.error(), 3 * error) << k;
    EXPECT_GT(estimate.error(), error / 3) << k;
  }
}

TEST(Estimate, OfAMotionThatIsLostIsNotLessThanItsError) {
  // Let go almost upright, a chain crumples: nothing can be foretold for long.
  const Case upright{"",
                     worlds::chain(11, 1, worlds::from_down(170)),
                     "dynamic-constraints",
                     {{"step", 1.0 / 960}, {"time_constant", 0.02}},
                     4};
  ErrorEstimate limits(upright.world, upright.method, upright.settings);
  bool above = false;
  double error = 0, told = 0;
  int late = 0;
  for (const Frame& frame : frames(upright)) {
    if (!above && frame.told > limits.limit()) {
      EXPECT_GT(frame.time, 0.1);
      EXPECT_LT(frame.error, 3 * frame.told);
      above = true;
    }
    if (frame.time < 3) continue;
    error += frame.error;
    told += frame.told;
    ++late;
  }
  EXPECT_TRUE(above);
  EXPECT_GT(error / late, 0.1) << "it is not lost";
  EXPECT_GT(told, error / 3);
  EXPECT_LT(told, error * 3);
}

}  // namespace
}  // namespace taut::error_estimate_test
