// The direct method wherever chains go: every pair of mass ratio, number of particles, frame rate,
// start angle and motion of the held end.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"

namespace taut::direct_sweep_test {
namespace {

constexpr double kLength = 0.5, kMass = 0.05;  // m, kg
constexpr double kTolerance = 1e-4;            // m
constexpr double kStretch = 1e-9;
constexpr double kGravity = 9.81;    // m/s^2
constexpr double kLongest = 0.5e-3;  // s between two samples of what a hand does

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

/// The hand goes to and fro over half the chain's length.
std::vector<PathKey> strokes(double speed) {
  std::vector<PathKey> keys;
  const double stroke = kLength / 2, time = stroke / speed;
  for (int k = 0; k < 4; ++k) {
    PathKey key;
    key.time = 0.02 + k * 2 * time;
    key.position = k % 2 == 0 ? Vec3(0, 0, 0) : Vec3(stroke, 0, stroke / 4);
    key.ease = true;
    keys.push_back(key);
  }
  return keys;
}

World world_of(const Case& c) {
  World world;
  const double angle = c.degrees * std::numbers::pi / 180;
  Connector chain = straight_connector("chain", kLength, kMass, c.particles, Vec3::Zero(),
                                       Vec3(std::sin(angle), -std::cos(angle), 0));
  chain.particle_mass.back() += c.mass_ratio * kMass;
  Attachment hand;
  if (c.whip > 0) {
    hand.kind = Attachment::Kind::path;
    hand.path = std::make_shared<Path>(strokes(c.whip));
  }
  chain.holds = {{0, hand, {}}};
  world.connectors = {chain};
  finish(world);
  return world;
}

/// The times (s) at which a motion is sampled: its frames and, where a hand moves, enough between
/// them to follow its work, among them those at which its acceleration jumps.
std::vector<double> sample_times(const Case& c, double duration) {
  const std::vector<double> frames = study::frame_times(duration, c.fps);
  if (c.whip == 0) return frames;
  std::vector<double> times = frames;
  const auto between = static_cast<int>(std::ceil(1 / (c.fps * kLongest) - 1e-9));
  for (const double frame : frames) {
    for (int k = 1; k < between; ++k) times.push_back(frame - k / (c.fps * double(between)));
  }
  for (const PathKey& key : strokes(c.whip)) times.push_back(key.time);
  std::erase_if(times, [&](double time) { return time < 0 || time > frames.back(); });
  std::ranges::sort(times);
  const auto same = [](double a, double b) { return b - a < 1e-9; };
  times.erase(std::unique(times.begin(), times.end(), same), times.end());
  return times;
}

/// The energy (J) that an error of the tolerance is worth: of place under the weight, and of speed
/// in the time for which that counts.
double explained(double mass, double kinetic) {
  const double memory = 0.15 * std::sqrt(kLength / kGravity);
  return kTolerance * mass * (kGravity + std::sqrt(2 * kinetic / mass) / memory);
}

void follow(const Case& c, double duration, double cpu_cap) {
#ifdef TAUT_SANITIZED
  cpu_cap *= 10;
#endif
  Simulation simulation(world_of(c), make_method("direct", {{"tolerance", kTolerance}}));
  study::EnergyBalance balance({});
  const double mass = kMass * (1 + c.mass_ratio);
  double cpu = 0, stretch = 0, left = 0, kinetic = 0;
  for (const double time : sample_times(c, duration)) {
    const double before = thread_seconds();
    simulation.advance_to(time);
    cpu += thread_seconds() - before;
    ASSERT_LT(cpu, cpu_cap) << "at " << time;
    stretch = std::max(stretch, stretch_max(simulation.world()));
    kinetic = std::max(kinetic, kinetic_energy(simulation.world()));
    left = std::max(left, std::abs(balance.next(simulation.world())));
  }
  EXPECT_TRUE(balance.complete());
  EXPECT_LT(stretch, kStretch);
  EXPECT_LT(left, explained(mass, c.whip > 0 ? kinetic : 0));
}

void sweep(const std::vector<std::size_t>& particles, double duration, double cpu_cap) {
  for (const Case& c : pairwise(particles)) {
    SCOPED_TRACE(testing::Message()
                 << "mass ratio " << c.mass_ratio << ", " << c.particles << " particles, " << c.fps
                 << " fps, " << c.degrees << " degrees, whip " << c.whip);
    EXPECT_NO_THROW(follow(c, duration, cpu_cap));
  }
}

TEST(DirectSweep, NothingFailsStretchesOrGainsEnergy) {
  sweep({2, 3, 11, 21, 51}, 0.15, 20);
}

TEST(DirectSweep, LongChainsNeitherFailStretchNorGainEnergy) {
  sweep({2, 11, 101, 1001, 3}, 0.1, 60);
}

// Most take seconds. Ten thousand particles that stand over a hand which whips tumble link by link,
// each of 0.05 mm, and every step resolves all of them: some 400 s.
TEST(LongDirectSweep, NothingFailsStretchesOrGainsEnergy) {
  sweep({2, 11, 101, 1001, 10000}, 0.1, 900);
}

// The same motion however the frames divide it.
TEST(DirectSweep, FrameRatesChangeNothingBeyondTheTolerance) {
  const World world = world_of({4, 21, 24, 90, 0});
  const auto end = [&](int fps) {
    Simulation simulation(world, make_method("direct", {{"tolerance", kTolerance}}));
    for (const double time : study::frame_times(0.5, fps)) simulation.advance_to(time);
    return simulation.world().connectors[0].position;
  };
  const std::vector<Vec3> slow = end(24), fast = end(240);
  double sum = 0;
  for (std::size_t k = 0; k < slow.size(); ++k) sum += (slow[k] - fast[k]).squaredNorm();
  EXPECT_LT(std::sqrt(sum / static_cast<double>(slow.size())), 2 * kTolerance);
}

}  // namespace
}  // namespace taut::direct_sweep_test
