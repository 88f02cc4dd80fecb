// The truth against known answers, and its two solvers against each other.
#include "sim/truth/truth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "worlds.h"

namespace taut::truth_test {
namespace {

using worlds::kGravity;

World after(const World& start, double time, const char* method = "truth",
            const Settings& settings = {}) {
  Simulation simulation(start, make_method(method, settings));
  simulation.advance_to(time);
  return simulation.world();
}

std::vector<double> frames(double duration, int fps) {
  std::vector<double> times;
  for (int k = 0; k <= std::lround(duration * fps); ++k) {
    times.push_back(k / static_cast<double>(fps));
  }
  return times;
}

/// The Laguerre polynomial L_n at x.
double laguerre(std::size_t n, double x) {
  double before = 0, now = 1;
  for (std::size_t k = 0; k < n; ++k) {
    const double m = static_cast<double>(k);
    before = std::exchange(now, ((2 * m + 1 - x) * now - m * before) / (m + 1));
  }
  return now;
}

// The modes of n hanging beads have w^2 = (g/l) x with L_n(x) = 0, and bead k from the top moves by
// L_{n-k}(x): half a period turns the shape over.
void expect_mode(std::size_t beads, double ratio) {
  const double w = ratio * std::sqrt(kGravity);  // the chain is a metre long
  const double x = w * w / kGravity / static_cast<double>(beads);
  EXPECT_NEAR(laguerre(beads, x), 0, 1e-6) << "the ratio is not that of a mode";
  World world = worlds::chain(beads + 1, 1, -Vec3::UnitY());
  const double small = 1e-6;  // m; the lift of the beads is of its square
  for (std::size_t k = 1; k <= beads; ++k) {
    world.connectors[0].position[k].x() = small * laguerre(beads - k, x);
  }
  const World end = after(world, std::numbers::pi / w);
  for (std::size_t k = 1; k <= beads; ++k) {
    EXPECT_NEAR(end.connectors[0].position[k].x(), -world.connectors[0].position[k].x(),
                1e-5 * small)
        << ratio << ", bead " << k;
  }
}

TEST(Truth, SmallSwingsHaveTheFrequenciesOfTheLaguerreZeros) {
  for (const double ratio : {1.17385464, 2.70084163, 4.25246152}) expect_mode(10, ratio);
  for (const double ratio : {1.18777009, 2.72810124, 4.28154669}) expect_mode(20, ratio);
  // The double pendulum: w^2 = (2 -+ sqrt 2) g/l, l half the length.
  for (const double sign : {-1.0, 1.0}) expect_mode(2, std::sqrt(2 * (2 + sign * std::sqrt(2.0))));
}

/// When the tip of a chain of `links` folded beside its hold reaches its length below, over the
/// time of free fall from the same height.
double fall_ratio(std::size_t links) {
  World world = worlds::chain(links + 1, 1, -Vec3::UnitY());
  Connector& chain = world.connectors[0];
  // Down half the length, across at the bottom by a link of an odd number, and up again.
  const std::size_t half = links / 2;
  for (std::size_t i = half + 1; i <= links; ++i) {
    chain.position[i] = chain.position[2 * half + 1 - i] + Vec3(chain.rest[0], 0, 0);
  }
  const double drop = 1 + chain.position[links].y();
  Simulation simulation(world, make_method("truth", {}));
  const double free_fall = std::sqrt(2 * drop / kGravity);
  // The tip's lowest point: where its velocity turns upwards.
  double before = 0, time = 0;
  while (time < 1.2 * free_fall) {
    before = simulation.world().connectors[0].velocity[links].y();
    time += free_fall / 2000;
    simulation.advance_to(time);
    if (time > free_fall / 2 && before < 0 &&
        simulation.world().connectors[0].velocity[links].y() >= 0) {
      break;
    }
  }
  return time / free_fall;
}

// The tip of a folded chain is pulled down by the part that hangs, v^2 = g x (2L-x)/(L-x): in the
// limit of many links it needs 0.847213 of the time of free fall. The fold is as wide as a link,
// which is an error in proportion to a link's length: extrapolated, its square remains.
TEST(Truth, AFoldedChainFallsFasterThanFreely) {
  const double coarse = fall_ratio(11), fine = fall_ratio(21), finest = fall_ratio(41);
  EXPECT_NEAR((coarse - 0.847213) / (fine - 0.847213), 21.0 / 11, 0.25);
  EXPECT_NEAR((fine - 0.847213) / (finest - 0.847213), 41.0 / 21, 0.25);
  EXPECT_NEAR((41 * finest - 21 * fine) / 20, 0.847213, 0.005);
}

TEST(Truth, EnergyIsKeptToABillionth) {
  const World worlds_at_rest[] = {worlds::chain(21, 1, Vec3::UnitX()), worlds::chain_with_box(11),
                                  worlds::garland()};
  for (const World& world : worlds_at_rest) {
    const double scale = world.bodies.empty() ? kGravity : kGravity * 0.5;  // about m g L, J
    EXPECT_NEAR(energy(after(world, 1)), energy(world), 1e-9 * scale);
  }
}

TEST(Truth, AFreeFlightKeepsMomentum) {
  World world = worlds::thrown(11);
  world.gravity.setZero();
  const World end = after(world, 1);
  EXPECT_LT((linear_momentum(end) - linear_momentum(world)).norm(), 1e-12);
  EXPECT_LT((angular_momentum(end) - angular_momentum(world)).norm(), 1e-12);
  EXPECT_NEAR(energy(end), energy(world), 1e-9 * energy(world));
}

TEST(Truth, LengthsHoldToRounding) {
  EXPECT_LT(stretch_max(after(worlds::garland(), 1)), 1e-12);
  EXPECT_LT(stretch_max(after(worlds::driven_chain(21), 0.5)), 1e-12);
}

TEST(Truth, TwoSolversAgreeToAHundredMillionthOverASwing) {
  const World swing = worlds::chain(21, 0.2, Vec3::UnitX());
  const truth::Reference truth =
      truth::solve_truth(swing, frames(2, 30), {.scored_error = 1e-6 * 0.2});
  EXPECT_GT(truth.horizon, 0.7);
  EXPECT_LT(truth.horizon, 1.4);  // by then a micrometre has grown to a millimetre
  EXPECT_LT(truth.self_error, 1e-8 * 0.2);
  EXPECT_EQ(truth.frames.size(), 61u);
}

TEST(Truth, TwoSolversAgreeOnBodiesAndDrivenEnds) {
  for (const World& world : {worlds::chain_with_box(11), worlds::driven_chain(11),
                             worlds::thrown(11), worlds::garland()}) {
    const truth::Reference truth =
        truth::solve_truth(world, frames(0.5, 20), {.scored_error = 1e-6});
    EXPECT_GT(truth.horizon, 0.2);
    EXPECT_LT(truth.self_error, 1e-8 * 0.3);  // the shortest of their connectors
  }
}

TEST(Truth, TwoSolversAgreeOnAPinThatStopsAMovingParticle) {
  Timeline timeline;
  timeline.pins.push_back({.connector = 0, .along = 0.5, .from = 0.2, .until = 0.4, .to = {}});
  const World swing = worlds::chain(11, 1, Vec3::UnitX());
  const truth::Reference truth =
      truth::solve_truth(swing, frames(0.6, 20), {.scored_error = 1e-6}, timeline);
  EXPECT_GT(truth.horizon, 0.25);  // past the pin's start
  EXPECT_LT(truth.self_error, 1e-8);
  EXPECT_LT((truth.frames[5].connectors[0][5] - truth.frames[7].connectors[0][5]).norm(), 1e-12);
  EXPECT_GT((truth.frames[3].connectors[0][5] - truth.frames[4].connectors[0][5]).norm(), 1e-2);
}

TEST(Truth, UprightStartsAreSoonUnpredictable) {
  const World drop = worlds::chain(21, 1, worlds::from_down(175));
  const truth::Reference truth = truth::solve_truth(drop, frames(1, 60), {.scored_error = 1e-4});
  EXPECT_LT(truth.horizon, 0.25);
  EXPECT_EQ(truth.frames.size(), 61u);
}

TEST(Truth, SaysWhereLengthsCannotBeKept) {
  World world = worlds::chain(5, 0.4, Vec3::UnitX());
  world.connectors[0].holds.push_back({4, worlds::fixed_at(Vec3(0.5, 0, 0))});
  finish(world);
  EXPECT_THROW(after(world, 0.1), Diverged);
}

}  // namespace
}  // namespace taut::truth_test
