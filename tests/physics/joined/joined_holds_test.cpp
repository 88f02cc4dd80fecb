// Pins, cuts and driven ends of connectors that are joined, and what they cost.
#include <gtest/gtest.h>

#include "joined_worlds.h"
#include "sim/links/tension.h"

namespace taut::joined_holds_test {
namespace {

using namespace joined_worlds;
using material_worlds::after;
using material_worlds::apart;

constexpr std::size_t kParticles = 7;

/// A branch, moved by a method while the joint is pinned by one of its particles, led away and let
/// go, a place beside it is pinned where no particle is, and a branch is cut.
World through_interventions(const char* method, const Settings& settings) {
  Simulation simulation(branch(kParticles), make_method(method, settings));
  World& world = simulation.world();
  Interventions& interventions = simulation.interventions();
  simulation.advance_to(0.05);
  const Pinned joint = interventions.pin(world, 2, 0);
  EXPECT_EQ(joint.outcome, Outcome::done) << words(joint.outcome);
  EXPECT_EQ(interventions.pin(world, 1, 0).outcome, Outcome::held_there);
  const Vec3 pinned = world.connectors[2].position.front();
  simulation.advance_to(0.1);
  EXPECT_EQ((world.connectors[0].position.back() - pinned).norm(), 0) << method;
  EXPECT_EQ(open(world), 0) << method;
  EXPECT_EQ(
      interventions.move(world, joint.pin, worlds::fixed_at(pinned + Vec3(-0.05, 0.02, 0)), 0.05),
      Outcome::done);
  simulation.advance_to(0.17);
  EXPECT_EQ(interventions.release(world, joint.pin), Outcome::done);
  simulation.advance_to(0.2);
  const Pinned beside = interventions.pin(world, 0, 0.22);
  EXPECT_EQ(beside.outcome, Outcome::done);
  EXPECT_EQ(world.joints[0].particles[0].particle, kParticles);  // one is before it now
  simulation.advance_to(0.25);
  EXPECT_EQ(interventions.release(world, beside.pin), Outcome::done);
  EXPECT_EQ(world.joints[0].particles[0].particle, kParticles - 1);
  EXPECT_LT(stretch_max(world), method == std::string("xpbd") ? 0.01 : 1e-9);
  EXPECT_EQ(interventions.cut(world, 0, 0.25).outcome, Outcome::done);
  EXPECT_EQ(world.joints[0].particles[0].connector, 3u);
  simulation.advance_to(0.3);
  EXPECT_EQ(open(world), 0) << method;
  return world;
}

TEST(JoinedHolds, PinsAndCuts) {
  const World truth = through_interventions("truth", {});
  EXPECT_LT(apart(through_interventions("direct", {{"tolerance", 1e-6}}), truth), 1e-5);
  const double coarse = apart(through_interventions("xpbd", {{"step", 1e-4}}), truth);
  const double fine = apart(through_interventions("xpbd", {{"step", 6.25e-6}}), truth);
  EXPECT_LT(fine, 5e-3);
  EXPECT_GT(coarse / fine, 4);
}

TEST(JoinedHolds, NoCutDividesAJoint) {
  World world = branch(kParticles);
  world.joints.push_back({{{1, 3}, {2, 6}}});
  Interventions interventions;
  EXPECT_EQ(interventions.cut(world, 1, 0.15).outcome, Outcome::joined_there);
  EXPECT_EQ(interventions.cut(world, 1, 0.16).outcome, Outcome::done);
}

// The part cut off falls: its centre of mass as a stone, its masses those of all that is joined.
TEST(JoinedHolds, WhatIsCutOffFalls) {
  World world = branch(kParticles);
  Interventions interventions;
  ASSERT_EQ(interventions.cut(world, 0, 0.25).outcome, Outcome::done);
  const auto fallen = [](const World& of) {
    Vec3 sum = Vec3::Zero();
    double mass = 0;
    for (const std::size_t c : {1, 2, 3}) {
      const Connector& connector = of.connectors[c];
      for (std::size_t i = 0; i < connector.particles(); ++i) {
        sum += connector.particle_mass[i] * connector.position[i];
        mass += connector.particle_mass[i];
      }
    }
    return Vec3(sum / mass);
  };
  const Vec3 drop(0, -9.81 * 0.3 * 0.3 / 2, 0);
  EXPECT_LT((fallen(after(world, 0.3, 1e-6)) - fallen(world) - drop).norm(), 1e-12);
}

// One joint, held by a driven point through any of its particles.
TEST(JoinedHolds, ADrivenJoint) {
  std::vector<PathKey> keys(2);
  keys[1].time = 0.3;
  World world = branch(kParticles);
  world.connectors[0].holds.clear();
  const Vec3 at = world.connectors[1].position[0];
  keys[0].position = at;
  keys[1].position = at + Vec3(0.1, 0.1, 0);
  world.connectors[2].holds = {{0, worlds::on_path(std::make_shared<const Path>(keys))}};
  finish(world);
  const World truth = after(world, 0.3, "truth", {});
  EXPECT_EQ((truth.connectors[0].position.back() - keys[1].position).norm(), 0);
  EXPECT_LT(apart(after(world, 0.3, 1e-6), truth), 1e-6);
}

// The beads of joined connectors come to rest on a floor, a radius above it; methods without
// contact beside joints refuse it.
TEST(JoinedHolds, BeadsOfJointsTouch) {
  World world = branch(kParticles);
  world.connectors[0].holds.clear();
  for (Connector& connector : world.connectors) connector.radius = 0.01;
  Obstacle floor;  // a plane
  floor.name = "floor";
  floor.place.position = Vec3(0, -0.8, 0);
  world.obstacles = {floor};
  finish(world);
  for (const char* method : {"springs", "xpbd", "direct", "truth"}) {
    const World end = after(world, 1.5, method, {});
    double lowest = 0;
    for (const Connector& connector : end.connectors) {
      for (const Vec3& place : connector.position) lowest = std::min(lowest, place.y());
    }
    EXPECT_NEAR(lowest, -0.79, 1e-9) << method;
    EXPECT_EQ(open(end), 0) << method;
  }
}

TEST(JoinedHolds, WorldsThatCannotBeAreRefused) {
  const auto says = [](const auto& spoil) -> std::string {
    World world = branch(kParticles);
    spoil(world);
    try {
      finish(world);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing";
  };
  const auto expect = [&](const char* text, const auto& spoil) {
    EXPECT_NE(says(spoil).find(text), std::string::npos) << says(spoil);
  };
  expect("nothing", [](World&) {});
  expect("two joints", [](World& world) { world.joints.push_back({{{0, 6}, {1, 3}}}); });
  expect("does not exist", [](World& world) { world.joints.push_back({{{0, 3}, {1, 7}}}); });
  expect("less than two", [](World& world) { world.joints.push_back({{{0, 3}}}); });
  expect("less than three links", [](World& world) { world.joints.push_back({{{1, 3}, {1, 5}}}); });
  expect("two particles of a joint are held", [](World& world) {
    for (const std::size_t c : {1, 2}) {
      world.connectors[c].holds = {{0, worlds::fixed_at(world.connectors[c].position[0])}};
    }
  });
  expect("massless span", [](World& world) { world.connectors[1].model = ConnectorModel::span; });
}

/// Ropes of four links that part in two, `levels` times.
World tree(std::size_t levels) {
  World world;
  const auto ropes = (std::size_t{1} << levels) - 1;
  for (std::size_t c = 0; c < ropes; ++c) {
    const std::size_t above = (c - 1) / 2;
    const Vec3 from = c > 0 ? world.connectors[above].position.back() : Vec3::Zero();
    const double aside = c % 2 == 0 ? 0.3 : -0.4;
    world.connectors.push_back(
        straight_connector("rope", 0.1, 0.01, 5, from, Vec3(aside, -1, 0.1 * aside).normalized()));
  }
  world.connectors[0].holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  for (std::size_t c = 0; 2 * c + 2 < ropes; ++c) {
    world.joints.push_back({{{c, 4}, {2 * c + 1, 0}, {2 * c + 2, 0}}});
  }
  finish(world);
  return world;
}

/// Products of the elimination, by the size of a world.
double products(const World& world) {
  JoinedTension system;
  system.rebuild(Mechanism(world));
  return system.products();
}

double slope(const World& small, const World& large) {
  const double growth = double(Mechanism(large).points()) / double(Mechanism(small).points());
  return std::log(products(large) / products(small)) / std::log(growth);
}

TEST(JoinedHolds, TreesAreSolvedInLinearTime) {
  EXPECT_LT(slope(tree(6), tree(12)), 1.02);
}

TEST(JoinedHolds, NetsAreSolvedInLessThanTheirPower1Point6) {
  EXPECT_LT(slope(net(10, 1), net(100, 1)), 1.6);
}

}  // namespace
}  // namespace taut::joined_holds_test
