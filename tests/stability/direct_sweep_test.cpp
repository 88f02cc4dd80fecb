// The direct method wherever chains go: every pair of mass ratio, number of particles, frame rate,
// start angle and motion of the held end.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "sim/measure.h"
#include "sim/method.h"
#include "sim/simulation.h"
#include "sim/study/run.h"

namespace taut {
namespace {

constexpr double kLength = 0.5, kMass = 0.05;  // m, kg
constexpr double kTolerance = 1e-4;            // m
constexpr double kStretch = 1e-9;

struct Case {
  double mass_ratio;  // of the load to the chain
  std::size_t particles;
  int fps;
  double degrees;  // of the start, from straight down
  double whip;     // m/s, of the held end
};

constexpr std::array<double, 4> kRatios = {1, 1e2, 1e4, 1e6};
constexpr std::array<int, 3> kRates = {24, 60, 1000};
constexpr std::array<double, 4> kAngles = {5, 90, 150, 179};
constexpr std::array<double, 3> kWhips = {0, 3, 15};

/// Rows in which every two values of different factors meet: the factors' indices run through
/// residues, as in an orthogonal array of strength two for the prime 5.
std::vector<Case> pairwise(const std::vector<std::size_t>& particles) {
  std::vector<Case> cases;
  for (std::size_t a = 0; a < 5; ++a) {
    for (std::size_t b = 0; b < 5; ++b) {
      cases.push_back({kRatios[a % kRatios.size()], particles[b % particles.size()],
                       kRates[(a + b) % 5 % kRates.size()],
                       kAngles[(a + 2 * b) % 5 % kAngles.size()],
                       kWhips[(a + 3 * b) % 5 % kWhips.size()]});
    }
  }
  return cases;
}

World world_of(const Case& c) {
  World world;
  const double angle = c.degrees * std::numbers::pi / 180;
  Connector chain = straight_connector("chain", kLength, kMass, c.particles, Vec3::Zero(),
                                       Vec3(std::sin(angle), -std::cos(angle), 0));
  chain.particle_mass.back() += c.mass_ratio * kMass;
  Attachment hand;
  if (c.whip > 0) {  // to and fro over half the chain's length
    std::vector<PathKey> keys;
    const double stroke = kLength / 2, time = stroke / c.whip;
    for (int k = 0; k < 4; ++k) {
      PathKey key;
      key.time = 0.02 + k * 2 * time;
      key.position = k % 2 == 0 ? Vec3(0, 0, 0) : Vec3(stroke, 0, stroke / 4);
      key.ease = true;
      keys.push_back(key);
    }
    hand.kind = Attachment::Kind::path;
    hand.path = std::make_shared<Path>(keys);
  }
  chain.holds = {{0, hand, {}}};
  world.connectors = {chain};
  finish(world);
  return world;
}

void sweep(const std::vector<std::size_t>& particles, double duration, double cpu_cap) {
  for (const Case& c : pairwise(particles)) {
    SCOPED_TRACE(testing::Message()
                 << "mass ratio " << c.mass_ratio << ", " << c.particles << " particles, " << c.fps
                 << " fps, " << c.degrees << " degrees, whip " << c.whip);
    const Problem problem{world_of(c), frame_times(duration, c.fps)};
    const Run result = run(problem, {"direct", {{"tolerance", kTolerance}}}, cpu_cap);
    EXPECT_EQ(result.end, Run::End::done) << result.reason << " at " << result.reached;
    EXPECT_LT(result.stretch_max, kStretch);
    if (c.whip > 0) continue;
    // What an error of position is worth, at most: weight times height.
    const double weight = kMass * (1 + c.mass_ratio) * 9.81;
    EXPECT_LT(std::max(result.energy_gain, result.energy_loss), 10 * weight * kTolerance);
  }
}

TEST(DirectSweep, NothingFailsStretchesOrGainsEnergy) {
  sweep({2, 3, 11, 21, 51}, 0.15, 20);
}

// Most take seconds. Ten thousand particles that stand over a hand which whips tumble link by link,
// each of 0.05 mm, and every step resolves all of them: some 500 s.
TEST(LongDirectSweep, NothingFailsStretchesOrGainsEnergy) {
  sweep({2, 11, 101, 1001, 10000}, 0.1, 900);
}

// The same motion however the frames divide it.
TEST(DirectSweep, FrameRatesChangeNothingBeyondTheTolerance) {
  const World world = world_of({4, 21, 24, 90, 0});
  const auto end = [&](int fps) {
    Simulation simulation(world, make_method("direct", {{"tolerance", kTolerance}}));
    for (const double time : frame_times(0.5, fps)) simulation.advance_to(time);
    return simulation.world().connectors[0].position;
  };
  const std::vector<Vec3> slow = end(24), fast = end(240);
  double sum = 0;
  for (std::size_t k = 0; k < slow.size(); ++k) sum += (slow[k] - fast[k]).squaredNorm();
  EXPECT_LT(std::sqrt(sum / static_cast<double>(slow.size())), 2 * kTolerance);
}

}  // namespace
}  // namespace taut
