// Where the paper's method stops being right, however small its steps.
#include <gtest/gtest.h>

#include <cmath>

#include "../physics/worlds.h"
#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"

namespace taut::paper_test {
namespace {

constexpr double kLength = 0.2;  // m

/// A horizontal rope of 50 g with a handle `ratio` times as heavy at its end.
study::Problem swing(double ratio) {
  study::Problem problem{{}, study::frame_times(0.5, 60)};
  problem.world.connectors = {
      straight_connector("rope", kLength, 0.05, 21, Vec3::Zero(), Vec3::UnitX())};
  Connector& rope = problem.world.connectors[0];
  rope.holds = {{0, {}}};
  rope.particle_mass.back() += 0.05 * ratio;
  finish(problem.world);
  return problem;
}

/// RMS over particles and frames, as a share of the length.
double error(const study::Problem& problem, double step) {
  const study::Run truth = study::run(problem, {"direct", {{"tolerance", 1e-7}}}, 60);
  const study::Run paper = study::run(problem, {"impulse", {{"step", step}}}, 60);
  return study::rms_error(paper.frames, truth.frames, 0.5,
                          study::share_of_length(kLength).distance);
}

// The rope's inertia and weight never reach the handle: that is left at any step. It is the less,
// the smaller the rope's share of the mass.
TEST(Paper, ErrorStopsFallingAtWhatTheModelMisses) {
  const study::Problem light = swing(4), heavy = swing(40);
  const double coarse = error(light, 1.0 / 960), fine = error(light, 1.0 / 15360);
  EXPECT_NEAR(fine / coarse, 1, 0.5) << "sixteen times finer, and no better";
  EXPECT_NEAR(fine, 0.04, 0.02);
  EXPECT_NEAR(error(heavy, 1.0 / 15360), 0.01, 0.005);
}

/// How often a hanging handle of four times the cord's mass turns round in a second.
int turns(double restitution) {
  constexpr double kStep = 0.001;
  World world;
  world.connectors = {straight_connector("cord", 1, 0.1, 2, Vec3::Zero(), -Vec3::UnitY())};
  Connector& cord = world.connectors[0];
  cord.holds = {{0, {}}};
  cord.particle_mass[1] = 0.4;
  cord.restitution = restitution;
  finish(world);
  Simulation simulation(world, make_method("impulse", {{"step", kStep}, {"as_printed", true}}));
  int count = 0;
  double before = 0;
  for (int i = 1; i <= 1000; ++i) {
    simulation.advance_to(i * kStep);
    const double speed = simulation.world().connectors[0].velocity.back().y();
    count += speed * before < 0;
    before = speed;
  }
  return count;
}

// Of the speed v that a handle parts with, the printed form leaves v (1 - (1 + e) m_a/(m_c + m_a)):
// more restitution e than the cord's share m_c/m_a, and each catch throws it back, without end.
TEST(Paper, TooMuchRestitutionMakesARestingHandleJitter) {
  EXPECT_EQ(turns(0.2), 0);
  EXPECT_EQ(turns(0.24), 0);
  EXPECT_GT(turns(0.4), 100);
  EXPECT_GT(turns(0.9), 100);
}

}  // namespace
}  // namespace taut::paper_test
