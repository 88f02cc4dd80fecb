// What a connector touches divides it, in the method of the paper: known answers.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "contact_worlds.h"
#include "sim/measure/measure.h"

namespace taut::impulse_contact_test {
namespace {

using namespace contact_worlds;
using worlds::kGravity;

/// Two weights (kg) on a light chain over half a turn of a post.
World over(double left, double right, double friction) {
  World world = over_post(12, 0, 20, 20, 0.02, 1e-4, friction);
  world.connectors[0].particle_mass.front() += left;
  world.connectors[0].particle_mass.back() += right;
  finish(world);
  return world;
}

Simulation by_impulse(const World& world, double step) {
  return {world, make_method("impulse", {{"step", step}})};
}

/// The ratio of pulls at which a polygon of 12 chords on half a turn begins to slide: 13 corners,
/// of which the first and the last bend it by half as much as the others.
double capstan_ratio(double friction) {
  const double half = std::numbers::pi / 24;
  const auto corner = [&](double half_bend) {
    const double rubs = friction * std::tan(half_bend);
    return (1 + rubs) / (1 - rubs);
  };
  return std::pow(corner(half), 11) * std::pow(corner(half / 2), 2);
}

// Weights that friction holds do not move; others by a = g (m - r m')/(m + r m'), r the capstan's
// ratio. A bead comes to the post and another leaves it with every link: the way over the corners
// is off by up to (l/2)^2/2R of a chord of l on a post of R.
TEST(ImpulseContact, HoldsOrLetsGoByTheCapstansRatio) {
  const double friction = 0.25, ratio = capstan_ratio(friction);
  constexpr double kTime = 0.25, kStep = 1e-3;  // s
  const double held = 0.98 * ratio;
  {
    const World world = over(1, held, friction);
    Simulation simulation = by_impulse(world, kStep);
    simulation.advance_to(kTime);
    EXPECT_LT(
        (simulation.world().connectors[0].position.back() - world.connectors[0].position.back())
            .norm(),
        1e-9);
  }
  for (const double mu : {0.0, friction}) {
    const double r = mu > 0 ? ratio : 1, heavy = 1.5 * r;
    const World world = over(1, heavy, mu);
    Simulation simulation = by_impulse(world, kStep);
    simulation.advance_to(kTime);
    const double sinks = kGravity * (heavy - r) / (heavy + r) * kTime * kTime / 2;
    const double post_radius = world.obstacles[0].shape.radius;
    const double chord = std::pow(0.02 / 2, 2) / 2 / post_radius;
    EXPECT_NEAR(world.connectors[0].position.back().y() -
                    simulation.world().connectors[0].position.back().y(),
                sinks, chord + 2 * kStep * kGravity * kTime)
        << mu;
  }
}

// A rope that falls on a ball and a floor is never inside, and comes to lie.
TEST(ImpulseContact, NothingIsInsideAtAStepsEnd) {
  World world = falling_rope(31, obstacle(sphere_shape(0.15), 0.3));
  world.obstacles[0].place.position = Vec3(0.3, 0.3, 0);
  world.obstacles.push_back(obstacle(plane_shape(), 0.5));
  finish(world);
  Simulation simulation = by_impulse(world, 1e-3);
  const double start = energy(world);
  for (int frame = 1; frame <= 180; ++frame) {
    simulation.advance_to(frame / 60.0);
    EXPECT_LE(penetration(simulation.world()), 1e-12) << frame;
  }
  EXPECT_LT(energy(simulation.world()), start / 2) << "it lies";
}

// A surface pulls at nothing that leaves it.
TEST(ImpulseContact, ABeadLeavesWhenPulledAway) {
  World world = pair(Vec3(0, 0, 0), Vec3::Zero(), obstacle(plane_shape(), 0.5));
  for (Vec3& velocity : world.connectors[0].velocity) velocity = Vec3(0, 1, 0);
  Simulation simulation = by_impulse(world, 1e-3);
  simulation.advance_to(0.1);
  EXPECT_NEAR(simulation.world().connectors[0].position[0].y(), 0.1 - kGravity * 0.01 / 2, 1e-9);
}

}  // namespace
}  // namespace taut::impulse_contact_test
