// Chains whose bends are damped, near what they may touch.
#include <gtest/gtest.h>

#include "sim/measure/measure.h"
#include "tests/physics/contact/contact_worlds.h"
#include "tests/physics/material/material_worlds.h"

namespace taut::contact_damping_test {
namespace {

using namespace contact_worlds;
using material_worlds::after;
using material_worlds::apart;

constexpr double kDamping = 2e-4;  // N m^2 s: waves over three links fade within some 0.1 s

/// A metre of chain that is bent where it starts, in the plane z = 0.
World bent_chain(double damping) {
  World world = worlds::chain(11, 1, Vec3::UnitX(), 0.5);
  Connector& chain = world.connectors[0];
  for (std::size_t i = 1; i < chain.particles(); ++i) {
    const double turn = i % 4 < 2 ? 0.5 : -0.4;
    chain.position[i] = chain.position[i - 1] + 0.1 * Vec3(std::cos(turn), std::sin(turn), 0);
  }
  Section section;
  section.bending_damping = damping;
  chain.sections.assign(chain.links(), section);
  chain.radius = 0.005;
  finish(world);
  return world;
}

/// Beside a wall that its beads may reach at any time, as fast as they are, and never do.
World beside_a_wall(World world) {
  Obstacle wall = obstacle(plane_shape(), 0.3);
  wall.place = {Vec3(0, 0, -0.006), rotation_between(Vec3::UnitY(), Vec3::UnitZ())};
  world.obstacles = {wall};
  finish(world);
  return world;
}

// The truth knows no contact beside materials; there is none here.
TEST(ContactDamping, BesideAWallAChainMovesAsWithout) {
  const World free = bent_chain(kDamping), near = beside_a_wall(free);
  const World truth = after(free, 0.5, "truth", {});
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    EXPECT_LT(apart(after(near, 0.5, tolerance), truth), tolerance);
  }
}

// What damps bends are forces between particles that turn nothing as a whole. Places are put onto
// the lengths of links after each step, which changes the angular momentum a little.
TEST(ContactDamping, KeepsMomenta) {
  World world = beside_a_wall(bent_chain(kDamping));
  world.gravity.setZero();
  Connector& chain = world.connectors[0];
  chain.holds.clear();
  for (std::size_t i = 0; i < chain.particles(); ++i) {
    chain.velocity[i] = Vec3(0.3, 0.2, 0) + 4 * Vec3::UnitZ().cross(chain.position[i]);
  }
  finish(world);
  constexpr double kTolerance = 1e-4;  // of a length of 1 m
  const World end = after(world, 0.5, kTolerance);
  EXPECT_LT(energy(end), 0.99 * energy(world));
  EXPECT_LT((linear_momentum(end) - linear_momentum(world)).norm(), 1e-11);
  EXPECT_LT((angular_momentum(end) - angular_momentum(world)).norm(),
            0.1 * kTolerance * angular_momentum(world).norm());
}

// A chain between two points falls on a post. Its lowest wave, of half a metre to either side of
// the post, fades at (damping / (mass per length)) (pi / 0.5 m)^4 / 2 = 6 / s: in 2 s to nothing.
// Undamped it hums for ever.
TEST(ContactDamping, AChainOverAPostComesToRest) {
  const auto fallen = [](double damping) {
    World world = bent_chain(damping);
    Connector& chain = world.connectors[0];
    chain.holds.push_back({10, worlds::fixed_at(chain.position.back())});
    const Vec3 middle = chain.position.back() / 2;
    world.obstacles = {post(0.05, middle - Vec3(0, 0.15, 0), 0.5)};
    finish(world);
    return after(world, 2, 1e-3);
  };
  EXPECT_GT(fastest(fallen(0)), 0.1);
  EXPECT_LT(fastest(fallen(20 * kDamping)), 0.01);
}

}  // namespace
}  // namespace taut::contact_damping_test
