// Forces of the user's own on connectors, with known answers.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::applied_force_test {
namespace {

std::shared_ptr<const AppliedForce> force(AppliedForce by) {
  return std::make_shared<const AppliedForce>(std::move(by));
}

Simulation run(const World& world, std::string_view method, const Settings& settings,
               double until) {
  Simulation simulation(world, make_method(method, settings));
  simulation.advance_to(until);
  return simulation;
}

const std::pair<const char*, Settings> kMethods[] = {
    {"direct", {{"tolerance", 1e-6}}}, {"truth", {}}, {"springs", {}}, {"xpbd", {}}};

// A force of m a on every particle is a gravity of a.
TEST(AppliedForce, OfTheMassesIsMoreGravity) {
  const Vec3 wind(3, 0, 1);
  for (const auto& [method, settings] : kMethods) {
    SCOPED_TRACE(method);
    World pushed = worlds::chain(6, 1, worlds::from_down(60));
    World heavier = pushed;
    heavier.gravity += wind;
    pushed.connectors[0].applied_force = force([&, mass = pushed.connectors[0].particle_mass](
                                                   double, const auto&, const auto&, auto& sum) {
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += mass[i] * wind;
    });
    refresh(pushed);
    const Simulation one = run(pushed, method, settings, 0.4);
    const Simulation other = run(heavier, method, settings, 0.4);
    for (std::size_t i = 0; i < 6; ++i) {
      const Vec3 apart =
          one.world().connectors[0].position[i] - other.world().connectors[0].position[i];
      EXPECT_LT(apart.norm(), 2e-6);
    }
  }
}

// A spring between a weight on a rod without gravity and its place: it swings on a line across the
// rod, as far as that is small, with the frequency sqrt(k / m).
TEST(AppliedForce, OfASpringHasItsFrequency) {
  constexpr double kStiffness = 50, kMass = 0.5;  // N/m, kg
  World world;
  world.gravity.setZero();
  Connector rod = straight_connector("rod", 1, 2 * kMass, 2, Vec3::Zero(), Vec3::UnitX());
  rod.velocity.assign(2, Vec3(0, 1, 0));
  rod.applied_force = force([kStiffness](double, const auto& at, const auto&, auto& sum) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i].y() -= kStiffness * at[i].y();
  });
  world.connectors = {rod};
  finish(world);
  const double frequency = std::sqrt(kStiffness / kMass);
  const double quarter = std::numbers::pi / 2 / frequency;
  for (const auto& [method, settings] : kMethods) {
    SCOPED_TRACE(method);
    const double close = std::string_view(method) == "direct"  ? 1e-5
                         : std::string_view(method) == "truth" ? 1e-7
                                                               : 6e-3;
    const Simulation there = run(world, method, settings, 5 * quarter);
    EXPECT_NEAR(there.world().connectors[0].position[1].y(), 1 / frequency, close);
    EXPECT_NEAR(there.world().connectors[0].velocity[1].y(), 0, 10 * close);
  }
}

// A body that hangs by a rope feels what pushes the particle that it holds, and drag by speed
// brakes it: with a force of -c v on a weight that falls, the speed tends to m g / c.
TEST(AppliedForce, ThatGrowsWithTheSpeedEndsAFall) {
  World world;
  Body ball;
  ball.name = "ball";
  ball.mass_properties = solid_sphere(0.9, 0.1);
  world.bodies = {ball};
  Connector rope = straight_connector("rope", 1, 0.1, 2, Vec3(0, 1, 0), -Vec3::UnitY());
  rope.holds = {{1, worlds::on_body(0, Vec3::Zero())}};
  constexpr double kDrag = 5;  // N s/m, of the two particles
  rope.applied_force = force([kDrag](double, const auto&, const auto& velocity, auto& sum) {
    sum[1] -= kDrag * velocity[1];
  });
  world.connectors = {rope};
  finish(world);
  const double mass = 1, time = 0.5, speed = mass * worlds::kGravity / kDrag;
  const Simulation fallen = run(world, "direct", {{"tolerance", 1e-6}}, time);
  EXPECT_NEAR(fallen.world().bodies[0].velocity.y(), -speed * (1 - std::exp(-kDrag * time / mass)),
              1e-5);
}

// What is pushed holds on to that: forces_of() has the force in its balance.
TEST(AppliedForce, IsInTheForcesOfHolds) {
  World world = worlds::chain(3, 1, -Vec3::UnitY(), 0.3);
  world.connectors[0].applied_force =
      force([](double, const auto&, const auto&, auto& sum) { sum[2].y() -= 7; });
  refresh(world);
  const Forces forces = forces_of(world);
  EXPECT_NEAR(forces.links[1].tension, 7 + 0.1 * worlds::kGravity, 1e-4);
  EXPECT_NEAR(forces.holds[0].force.y(), 7 + 0.3 * worlds::kGravity, 1e-4);
}

TEST(AppliedForce, FollowsJointsPinsAndCuts) {
  World world = worlds::chain(5, 1, Vec3::UnitX());
  Connector branch = straight_connector("branch", 0.5, 0.5, 3, Vec3(0.5, 0, 0), Vec3::UnitZ());
  std::size_t seen = 0;
  branch.applied_force = force([&seen](double, const auto& at, const auto&, auto& sum) {
    seen = at.size();
    for (Vec3& push : sum) push.y() += 1;
  });
  world.connectors.push_back(branch);
  world.joints = {{{{0, 2}, {1, 0}}}};
  refresh(world);
  Simulation simulation(world, make_method("direct", {}));
  simulation.advance_to(0.01);
  EXPECT_EQ(seen, 3u);
  // The particle of the joint weighs a sixth of the branch and a fifth of the chain.
  EXPECT_EQ(simulation.interventions().pin(simulation.world(), 1, 0.3).outcome, Outcome::done);
  simulation.advance_to(0.02);
  EXPECT_EQ(seen, 4u);
  EXPECT_EQ(simulation.interventions().cut(simulation.world(), 1, 0.4).outcome, Outcome::done);
  simulation.advance_to(0.03);
  EXPECT_TRUE(simulation.world().connectors[2].applied_force);
}

TEST(AppliedForce, IsRefusedByNameElsewhere) {
  World world = worlds::chain(3, 1, Vec3::UnitX());
  world.connectors[0].applied_force = force([](double, const auto&, const auto&, auto&) {});
  refresh(world);
  EXPECT_EQ(refusal(*find_method("impulse"), world),
            "does not follow applied forces (connector chain)");
  EXPECT_EQ(methods_that_follow(world), "springs, xpbd, direct, truth");
}

}  // namespace
}  // namespace taut::applied_force_test
