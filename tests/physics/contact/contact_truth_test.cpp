// The truth among obstacles: located events against known answers, and against the time stepping
// of the direct method, which shares no equation with them.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "contact_worlds.h"
#include "sim/measure/measure.h"
#include "sim/truth/truth.h"

namespace taut::contact_truth_test {
namespace {

using namespace contact_worlds;
using worlds::kGravity;

constexpr double kRounding = 1e-10;

Simulation by_truth(const World& world) {
  return {world, make_method("truth", {})};
}

double apart(const World& a, const World& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.connectors[0].particles(); ++i) {
    most = std::max(most, (a.connectors[0].position[i] - b.connectors[0].position[i]).norm());
  }
  return most;
}

TEST(ContactTruth, ABeadBouncesAsNewtonSays) {
  const double lands = std::sqrt(2 / kGravity);
  for (const double e : {0.0, 0.5, 1.0}) {
    Simulation simulation =
        by_truth(pair(Vec3(0, 1, 0), Vec3::Zero(), obstacle(plane_shape(), 0, e)));
    for (int frame = 1; frame <= 40; ++frame) {
      const double time = frame / 60.0, after = time - lands;
      simulation.advance_to(time);
      const double speed = after < 0 ? 0 : e * kGravity * lands;
      const double height = after < 0 ? 1 - kGravity * time * time / 2
                                      : std::max(0.0, speed * after - kGravity * after * after / 2);
      EXPECT_NEAR(simulation.world().connectors[0].position[0].y(), height, kRounding)
          << "restitution " << e << " at " << time;
    }
  }
}

TEST(ContactTruth, ABeadStopsWhereItMustAndStays) {
  constexpr double speed = 2, kinetic = 0.3;
  const double angle = std::atan(0.5);
  const Vec3 up(std::cos(angle), std::sin(angle), 0);
  Obstacle incline = obstacle(plane_shape(), kinetic);
  incline.place.rotation = Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
  for (const double holds : {0.4, 0.6}) {  // tan a is between
    incline.static_friction = holds;
    Simulation simulation = by_truth(pair(Vec3::Zero(), speed * up, incline));
    simulation.advance_to(1);
    const double slowing = kGravity * (std::sin(angle) + kinetic * std::cos(angle));
    const double falls = kGravity * (std::sin(angle) - kinetic * std::cos(angle));
    const double rest = 1 - speed / slowing;  // s
    const double back = holds < 0.5 ? falls * rest * rest / 2 : 0;
    EXPECT_NEAR(simulation.world().connectors[0].position[0].dot(up),
                speed * speed / (2 * slowing) - back, kRounding);
  }
}

/// A chain that swings from the horizontal against a post.
World against_a_post(double friction) {
  World world = worlds::chain(13, 1, Vec3::UnitX(), 0.1);
  world.connectors[0].radius = 0.005;
  world.obstacles = {post(0.05, Vec3(0.1, -0.3, 0), friction)};
  world.topology = structure(world);
  return world;
}

TEST(ContactTruth, TwoSolversAgree) {
  for (const double friction : {0.0, 0.3}) {
    const World world = against_a_post(friction);
    Simulation truth = by_truth(world);
    truth.advance_to(0.6);
    EXPECT_LE(penetration(truth.world()), 1e-11);
    EXPECT_LT(stretch_max(truth.world()), 1e-11);
    double before = 0;
    for (const double step : {4e-4, 2e-4, 1e-4}) {
      Simulation other(world, make_method("direct", {{"step", step}}));
      other.advance_to(0.6);
      const double error = apart(truth.world(), other.world());

      if (before > 0) {
        EXPECT_LT(error, 0.7 * before);
      }
      before = error;
    }
    EXPECT_LT(before, 1e-5);
  }
}

// The chain meets the post after 0.3 s; what is scored is known well beyond that, by both solvers.
TEST(ContactTruth, StatesHowFarItIsKnown) {
  std::vector<double> times;
  for (int frame = 0; frame <= 18; ++frame) times.push_back(frame / 30.0);
  const truth::TruthOptions options;
  const truth::Reference truth = truth::solve_truth(against_a_post(0.3), times, options);
  EXPECT_GE(truth.horizon, 0.4);
  EXPECT_GT(truth.self_error, 0);
  EXPECT_LE(truth.self_error, options.scored_error / 100);
}

}  // namespace
}  // namespace taut::contact_truth_test
