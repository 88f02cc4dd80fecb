// Connectors that are joined: branches, closed loops and nets, against the truth and known answers.
#include <gtest/gtest.h>

#include "joined_worlds.h"
#include "sim/links/mechanism.h"
#include "sim/links/tension.h"
#include "sim/truth/truth.h"

namespace taut::joined_test {
namespace {

using namespace joined_worlds;
using material_worlds::after;
using material_worlds::apart;
using material_worlds::section;

/// A loop that is no circle any more: it falls beside a fixed point at which it is held.
World hung_loop() {
  World world = ring(12, 0.2, 0.3);
  world.gravity = Vec3(0, -9.81, 0);
  world.connectors[0].holds = {{3, worlds::fixed_at(world.connectors[0].position[3])}};
  for (Vec3& velocity : world.connectors[0].velocity) velocity = Vec3(0, 0, 0.5);
  finish(world);
  return world;
}

/// A box that carries a branch and a stay, joined at the very point of the box.
World laden_box() {
  World world = worlds::chain_with_box(6);
  const Vec3 at = world.connectors[0].position.back();
  const Connector tail = straight_connector("tail", 0.3, 0.1, 5, at, Vec3(1, -1, 1).normalized());
  reweigh(world.bodies[0], world.bodies[0].bare);
  world.connectors.push_back(tail);
  world.joints = {{{{1, 0}, {0, 5}}}};
  finish(world);
  return world;
}

struct Case {
  const char* name;
  World world;
};

std::vector<Case> cases() {
  World elastic = branch(7);
  for (Connector& connector : elastic.connectors) {
    connector.sections.assign(connector.links(), section(200, 0.002));
  }
  finish(elastic);
  return {{"branch", branch(7)},
          {"loop", hung_loop()},
          {"net", net(4, 0.3)},
          {"box", laden_box()},
          {"elastic", elastic}};
}

TEST(Joined, DirectKeepsToItsTolerance) {
  for (const Case& each : cases()) {
    const World truth = after(each.world, 0.4, "truth", {});
    EXPECT_EQ(open(truth), 0) << each.name;
    for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
      const World end = after(each.world, 0.4, tolerance);
      EXPECT_LT(apart(end, truth), tolerance) << each.name << " " << tolerance;
      EXPECT_EQ(open(end), 0) << each.name;
    }
  }
}

// DOP853: its places are of order 8 in the step.
TEST(Joined, DirectIsOfEighthOrder) {
  const World start = branch(4);
  const World truth = after(start, 0.3, "truth", {});
  const double coarse = apart(after(start, 0.3, "direct", {{"step", 1.0 / 60}}), truth);
  const double fine = apart(after(start, 0.3, "direct", {{"step", 1.0 / 120}}), truth);
  EXPECT_GT(std::log2(coarse / fine), 7);
  EXPECT_LT(std::log2(coarse / fine), 9.5);
}

// Two ropes end to end are one, whatever part of the joint's mass is whose.
TEST(Joined, TwoRopesEndToEndAreOne) {
  const Section soft = section(300, 0);
  for (const Section* made : {static_cast<const Section*>(nullptr), &soft}) {
    const World one = rope(9, made), two = in_two(one, 3);
    EXPECT_LT(apart_in_two(after(one, 0.4, "truth", {}), after(two, 0.4, "truth", {}), 3), 1e-9);
    EXPECT_LT(apart_in_two(after(one, 0.4, 1e-6), after(two, 0.4, 1e-6), 3), 2e-6);
    for (const char* method : {"springs", "xpbd"}) {
      const Settings steps{{"step", 1e-4}};
      EXPECT_LT(apart_in_two(after(one, 0.2, method, steps), after(two, 0.2, method, steps), 3),
                1e-9)
          << method;
    }
  }
}

// A polygon of n links of mass m each that turns at w: each link pulls with m w^2 R / (2
// sin(pi/n)), which is rho v^2 for many.
TEST(Joined, TensionOfASpinningRing) {
  constexpr std::size_t kSides = 200;
  constexpr double kRadius = 0.5, kMass = 0.8, kSpin = 7;
  const World world = spinning_ring(kSides, kRadius, kMass, kSpin * Vec3::UnitZ());
  Mechanism mechanism(world);
  std::vector<double> state, right, tension;
  mechanism.load(world, state);
  mechanism.update(0, state.data());
  TensionSystem system(mechanism);
  for (std::size_t r = 0; r < kSides; ++r) right.push_back(mechanism.free_acceleration(r));
  system.assemble(mechanism);
  EXPECT_TRUE(system.solve(right, tension));
  const double mass = kMass / kSides, half = std::numbers::pi / kSides;
  const double known = mass * kSpin * kSpin * kRadius / (2 * std::sin(half));
  // The matrix is worse conditioned than one by (sides / pi)^2.
  for (const double each : tension) EXPECT_NEAR(each, known, 1e-11 * known);
  const double speed = kSpin * kRadius, density = kMass / (2 * std::numbers::pi * kRadius);
  EXPECT_NEAR(known, density * speed * speed, half * half * known);
}

TEST(Joined, ASpinningRingKeepsItsCircleAndItsMomentum) {
  constexpr double kRadius = 0.5, kSpin = 10;
  for (const char* method : {"truth", "direct"}) {
    const World start = spinning_ring(40, kRadius, 0.8, kSpin * Vec3::UnitZ());
    const Vec3 momentum = angular_momentum(start, Vec3::Zero());
    const World end = after(start, 2, method, {});  // three turns
    for (const Vec3& place : end.connectors[0].position) {
      EXPECT_NEAR(place.norm(), kRadius, 1e-5) << method;
    }
    const Vec3 first = end.connectors[0].position[0];
    EXPECT_LT((first - kRadius * Vec3(std::cos(2 * kSpin), std::sin(2 * kSpin), 0)).norm(), 1e-4);
    EXPECT_LT((angular_momentum(end, Vec3::Zero()) - momentum).norm(), 1e-8 * momentum.norm());
  }
}

// Thrown, turning and out of shape: what nothing touches keeps its energy and its momenta.
TEST(Joined, AFreeLoopKeepsWhatItHas) {
  World start = spinning_ring(16, 0.3, 0.4, Vec3(1, 2, 5));
  for (std::size_t i = 0; i <= 16; ++i) {
    start.connectors[0].velocity[i] += Vec3(0, 0, i == 4 || i == 11 ? 1 : 0);
  }
  start = after(start, 0.01, "truth", {});  // velocities that stretch nothing
  const World end = after(start, 2, 1e-6);
  const double scale = kinetic_energy(start);
  EXPECT_NEAR(energy(end), energy(start), 1e-6 * scale);
  EXPECT_LT((linear_momentum(end) - linear_momentum(start)).norm(), 1e-10);
  EXPECT_LT((angular_momentum(end, Vec3::Zero()) - angular_momentum(start, Vec3::Zero())).norm(),
            1e-6 * angular_momentum(start, Vec3::Zero()).norm());
  EXPECT_LT(stretch_max(end), 1e-12);
}

/// Two arms from fixed points at the same height, and a trunk that hangs where they meet.
World bridle(double arm_mass, double trunk_mass) {
  constexpr std::size_t kLinks = 6;
  // Together the arms are one chain whose middle particle weighs what the trunk does.
  Connector both =
      straight_connector("arms", 1, arm_mass, 2 * kLinks + 1, Vec3::Zero(), Vec3::UnitX());
  both.particle_mass[kLinks] += trunk_mass;
  const Vec3 far(0.7, 0, 0), down(0, -9.81, 0);
  both.position = hanging_points(both, Vec3::Zero(), far, down);
  both.particle_mass[kLinks] -= trunk_mass;
  both.holds = {{0, worlds::fixed_at(Vec3::Zero())}, {2 * kLinks, worlds::fixed_at(far)}};
  World world;
  Connector trunk = straight_connector("trunk", 0.4, trunk_mass, 5, both.position[kLinks], down);
  world.connectors = {both, trunk};
  world.joints = {{{{1, 0}, {0, kLinks}}}};
  finish(world);
  return world;
}

// A catenary with a load in its middle, and a rope below it, hang at rest.
TEST(Joined, ABridleHangsAtRest) {
  const World start = bridle(0.3, 0.5);
  // The discrete catenary is known to 1e-9 of its length; what is off swings with that amplitude.
  EXPECT_LT(apart(after(start, 1, 1e-4), start), 1e-8);
  EXPECT_LT(apart(after(start, 1, "truth", {}), start), 1e-8);
}

// With next to no mass the arms are straight: the joint hangs at the corner of a triangle.
TEST(Joined, MasslessArmsOfABridleAreStraight) {
  const World start = bridle(1e-6, 0.5);
  const Vec3 joint = start.connectors[1].position.front();
  EXPECT_NEAR(joint.x(), 0.35, 1e-6);
  EXPECT_NEAR(joint.y(), -std::sqrt(0.5 * 0.5 - 0.35 * 0.35), 1e-6);
  EXPECT_LT(apart(after(start, 0.1, 1e-4), start), 1e-6);
}

TEST(Joined, GamesMethodsConvergeToTheTruth) {
  for (const Case& each : cases()) {
    if (std::string(each.name) == "elastic") continue;  // its springs are springs' own
    const World truth = after(each.world, 0.2, "truth", {});
    // Stiff links are off by what they stretch, T/k, under 1e-4 m.
    const Settings springs{{"stiffness", 1e6}, {"step", 1e-5}};
    EXPECT_LT(apart(after(each.world, 0.2, "springs", springs), truth), 2e-3) << each.name;
    const double coarse = apart(after(each.world, 0.2, "xpbd", {{"step", 1e-4}}), truth);
    const double fine = apart(after(each.world, 0.2, "xpbd", {{"step", 2.5e-5}}), truth);
    EXPECT_LT(fine, 5e-3) << each.name;
    EXPECT_GT(coarse / fine, 2.5) << each.name;
  }
}

TEST(Joined, TheStepOfSpringsIsStable) {
  for (const Case& each : cases()) {
    const World end = after(each.world, 1, "springs", {});
    EXPECT_LT(stretch_max(end), each.world.connectors[0].sections.empty() ? 0.05 : 0.5)
        << each.name;
  }
}

TEST(Joined, TheTwoSolversOfTheTruthAgree) {
  const std::vector<double> times{0.1, 0.2};
  const truth::Reference truth = truth::solve_truth(net(3, 0.2), times);
  EXPECT_EQ(truth.horizon, 0.2);
  EXPECT_LT(truth.self_error, 1e-6);
}

TEST(Joined, OthersRefuseByName) {
  std::size_t refused = 0;
  for (const MethodInfo& method : all_methods()) {
    if (method.abilities.follows.has(Feature::joint) || !method.missing.empty()) continue;
    World world = branch(4);
    try {
      make_method(method.name, {})->advance(world, 0.01);
      ADD_FAILURE() << method.name;
    } catch (const Diverged& refusal) {
      EXPECT_NE(std::string(refusal.what()).find("joints (connectors trunk and right)"),
                std::string::npos)
          << refusal.what();
      ++refused;
    }
  }
  EXPECT_GE(refused, 3u);
}

}  // namespace
}  // namespace taut::joined_test
