#include <gtest/gtest.h>

#include <cmath>

#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"
#include "sim/run/simulation.h"

namespace taut::energy_balance_test {
namespace {

std::shared_ptr<const Path> moving(const Vec3& from, const Vec3& to) {
  return std::make_shared<const Path>(
      std::vector<PathKey>{{0, from}, {0.4, to}, {0.8, from}, {1.2, to}});
}

/// A chain with a weight, its upper end moved about.
World driven() {
  World world;
  Connector chain = straight_connector("chain", 0.3, 0.05, 6, {0, 0, 0}, {0, -1, 0});
  chain.particle_mass.back() += 0.2;
  Attachment hand;
  hand.kind = Attachment::Kind::path;
  hand.path = moving({0, 0, 0}, {0.2, 0.1, 0.1});
  chain.holds = {{0, hand}};
  world.connectors.push_back(std::move(chain));
  finish(world);
  return world;
}

struct Found {
  double left = 0;  // J, the most that nothing accounts for
  double gain = 0;  // J, the most by which the energy differs from that of the start
  bool complete = false;
};

Found follow(const World& world, const Timeline& timeline, const char* method,
             const Settings& settings) {
  Simulation simulation(world, make_method(method, settings), timeline);
  study::EnergyBalance balance(timeline);
  const auto energy = [&] {
    return kinetic_energy(simulation.world()) + potential_energy(simulation.world());
  };
  const double start = energy();
  Found found;
  for (int k = 0; k <= 60; ++k) {
    simulation.advance_to(k / 60.0);
    found.left = std::max(found.left, std::abs(balance.next(simulation.world())));
    found.gain = std::max(found.gain, std::abs(energy() - start));
  }
  found.complete = balance.complete();
  return found;
}

TEST(EnergyBalance, LeavesNothingOfWhatADriveDoes) {
  const Found found = follow(driven(), {}, "direct", {{"tolerance", 1e-8}});
  EXPECT_TRUE(found.complete);
  EXPECT_GT(found.gain, 0.05);
  // The cubic through a frame of a swing of 10 rad/s is off by (w dt)^4 / 384 of its size.
  EXPECT_LT(found.left, 1e-4 * found.gain);
}

TEST(EnergyBalance, ShowsWhatAMethodLoses) {
  const Found found = follow(driven(), {}, "xpbd", {{"step", 1.0 / 120}, {"compliance", 1e-3}});
  EXPECT_GT(found.left, 1e-2 * found.gain);
}

TEST(EnergyBalance, StartsAnewAfterAnIntervention) {
  World world = driven();
  world.connectors[0].holds[0].to = Attachment{};
  world.connectors[0].velocity.back() = {1, 0, 0};
  Timeline timeline;
  TimedPin& pin = timeline.pins.emplace_back();
  pin.along = 0.15;
  pin.from = 0.35;
  pin.until = 0.7;
  const Found found = follow(world, timeline, "direct", {{"tolerance", 1e-8}});
  EXPECT_TRUE(found.complete);
  EXPECT_GT(found.gain, 1e-4) << "the pin stops what moved";
  EXPECT_LT(found.left, 1e-6 * found.gain);
}

TEST(EnergyBalance, TwoDrivesAreNotToldApart) {
  World world = driven();
  Connector& chain = world.connectors[0];
  Attachment other;
  other.kind = Attachment::Kind::path;
  other.path = moving({0.15, -0.1, 0}, {0.12, -0.05, 0});
  chain.holds.push_back({5, other});
  chain.position = hanging_points(chain, {0, 0, 0}, {0.15, -0.1, 0}, world.gravity);
  finish(world);
  EXPECT_FALSE(follow(world, {}, "direct", {{"tolerance", 1e-6}}).complete);
}

}  // namespace
}  // namespace taut::energy_balance_test
