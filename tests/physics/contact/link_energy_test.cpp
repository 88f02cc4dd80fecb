// Links at thick obstacles lose energy and never gain any, by the direct method.
#include <gtest/gtest.h>

#include <algorithm>

#include "link_worlds.h"
#include "sim/measure/measure.h"

namespace taut::link_energy_test {
namespace {

using namespace link_worlds;

/// Housner (1963): a block that rocks keeps ((I - m a^2)/(I + m a^2))^2 of its energy as the other
/// edge, 2a aside, takes it over. The edges are sharp, and links thin: its axis is where they are.
TEST(LinkEnergy, ARodThatRocksLosesWhatHousnerFound) {
  constexpr double kInertia = 0.25;  // m^2, over the mass
  for (const double half : {0.1, 0.2, 0.3}) {
    for (const double angle : {0.005, 0.03}) {
      for (const double fps : {60.0, 1000.0}) {
        const World world = rocking_rod(half, angle, 0);
        const double flat = 0.2 * kGravity * kThin, arm = half * half;
        const double kept = std::pow((kInertia - arm) / (kInertia + arm), 2);
        // At a constant torque it lands after sqrt(2 angle (I + a^2)/(g a)).
        const double lands = std::sqrt(2 * angle * (kInertia + arm) / (kGravity * half));
        Simulation simulation = by_direct(world, 1e-6);
        const double before = energy(world) - flat;
        for (double time = 0; time < 1.3 * lands;) {
          time = std::min(time + 1 / fps, 1.3 * lands);
          simulation.advance_to(time);
        }
        EXPECT_NEAR((energy(simulation.world()) - flat) / before, kept, 1e-4)
            << half << ' ' << angle << ' ' << fps;
      }
    }
  }
}

TEST(LinkEnergy, NoRopeGainsAnyOnThickPosts) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const World world = rope_on_posts(seed);
    // Steps keep energy in second order.
    Simulation simulation(world, make_method("direct", {{"step", 2e-3}}));
    const double scale = energy_scale(world);
    double least = energy(world);
    for (int frame = 1; frame <= 120; ++frame) {
      simulation.advance_to(frame / 120.0);
      ASSERT_LE(energy(simulation.world()), least + 1e-3 * scale) << seed << ' ' << frame;
      ASSERT_LE(penetration_of_links(simulation.world()), 1e-9) << seed << ' ' << frame;
      least = std::min(least, energy(simulation.world()));
    }
  }
}

/// What gets to a surface just where a step ends, be it before or after by rounding, is thrown
/// back.
TEST(LinkEnergy, WhatArrivesAsAStepEndsIsThrownBack) {
  constexpr double kRestitution = 0.5, kArrives = 0.1;
  for (const bool links : {false, true}) {
    for (const double early : {-3e-10, -1e-12, 0.0, 1e-12, 3e-10}) {
      World world = pair(Vec3::Zero(), Vec3::Zero(), post(0.3, Vec3::Zero()));
      world.obstacles[0].restitution = kRestitution;
      Connector& rod = world.connectors[0];
      rod.links_touch = links;
      const double height = 0.3 + kGravity * kArrives * kArrives / 2 + early;
      // Along the post its beads touch, across it the middle of its link.
      rod.position = {Vec3(0, height, 0), Vec3(0, height, rod.length)};
      if (links) rod.position = {Vec3(-rod.length / 2, height, 0), Vec3(rod.length / 2, height, 0)};
      finish(world);
      Simulation simulation = by_direct(world, 1e-6);
      simulation.advance_to(kArrives);
      constexpr double kLater = 0.02;
      simulation.advance_to(kArrives + kLater);
      const double speed = kRestitution * kGravity * kArrives - kGravity * kLater;
      for (const Vec3& velocity : simulation.world().connectors[0].velocity) {
        // An impact takes a tenth of a microsecond, in which gravity goes on.
        EXPECT_NEAR(velocity.y(), speed, (1 + kRestitution) * kGravity * 1.1e-7) << links << early;
      }
    }
  }
}

}  // namespace
}  // namespace taut::link_energy_test
