// Beads of connectors that touch free bodies: as games do it of first order in the step.
#include <gtest/gtest.h>

#include "contact_sticks.h"
#include "sim/measure/measure.h"
#include "tests/physics/joined/joined_worlds.h"

namespace taut::bead_pairs_test {
namespace {

using namespace contact_sticks;

constexpr double kStep = 1.0 / 3840;                         // s
constexpr double kGain = kGravity * kStep;                   // m/s, of speed in a step
constexpr double kBead = 0.05, kBall = 0.4;                  // kg
constexpr double kThick = 0.004, kSize = 0.05, kLink = 0.3;  // m

Body large_ball(const Vec3& centre, const Vec3& velocity = Vec3::Zero()) {
  Body body = ball(centre, velocity);
  body.mass_properties = solid_sphere(kBall, 2 * kSize);
  body.capsule.radius = kSize;
  return body;
}

void touch(World& world, double friction = 0, double restitution = 0) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    world.bead_pairs.push_back({c, 0, friction, friction, restitution});
  }
}

/// Two beads, a link along z between them, of which the first meets a ball at rest along `normal`,
/// out of the ball.
World bead_meets_ball(const Vec3& normal, const Vec3& velocity, double friction, double e) {
  World world;
  world.gravity.setZero();
  const Vec3 at = (kThick + kSize) * normal - 0.1 * velocity;
  Connector link = straight_connector("link", kLink, 2 * kBead, 2, at, Vec3::UnitZ());
  link.radius = kThick;
  for (Vec3& v : link.velocity) v = velocity;
  world.connectors = {link};
  world.bodies = {large_ball(Vec3::Zero())};
  touch(world, friction, e);
  finish(world);
  return world;
}

/// The deepest that a bead is in the ball, m.
double depth_in_ball(const World& world) {
  double deepest = -1;
  for (const Connector& connector : world.connectors) {
    for (const Vec3& at : connector.position) {
      const double apart = (at - world.bodies[0].position).norm();
      deepest = std::max(deepest, kSize + connector.radius - apart);
    }
  }
  return deepest;
}

class BeadPairs : public testing::TestWithParam<const char*> {
 protected:
  Simulation simulate(const World& start, double step = kStep) const {
    return {start, make_method(GetParam(), {{"step", step}})};
  }
  World after(const World& start, double time) const {
    Simulation simulation = simulate(start);
    simulation.advance_to(time);
    return simulation.world();
  }
};

/// The same in nets, whose beads are joined.
class BeadsOfNets : public BeadPairs {};

// A bead responds with its own mass, as its link lies across: J = (1 + e) v/(1/m + 1/M). What it
// gets turns the link, by the angle of a step, and what is across that comes back to it.
TEST_P(BeadPairs, ABeadHitsABall) {
  constexpr double kSpeed = 2;
  for (const double e : {0.0, 0.5, 1.0}) {
    const World start = bead_meets_ball(Vec3::UnitY(), -kSpeed * Vec3::UnitY(), 0, e);
    const World world = after(start, 0.1 + 2 * kStep);
    const double impulse = (1 + e) * kSpeed / (1 / kBead + 1 / kBall);
    EXPECT_LT((linear_momentum(world) - linear_momentum(start)).norm(), 1e-15 / kStep);
    EXPECT_NEAR(world.bodies[0].velocity.y(), -impulse / kBall,
                std::pow(2 * kSpeed * kStep / kLink, 2) * impulse / kBall)
        << e;
    EXPECT_LE(depth_in_ball(world), 1e-8 * kSpeed * kStep);
    EXPECT_LT(energy(world), (1 + 1e-9) * energy(start));
  }
}

// Coulomb: mu times the push across it, as long as it slides. A bead does not turn, the ball does.
TEST_P(BeadPairs, FrictionOfAGrazingBead) {
  constexpr double kMu = 0.3, kIn = 1, kAlong = 2;  // m/s
  const World start = bead_meets_ball(Vec3::UnitY(), Vec3(kAlong, -kIn, 0), kMu, 0);
  const World world = after(start, 0.1 + 2 * kStep);
  const double push = kIn / (1 / kBead + 1 / kBall);
  // In a step the normal turns by its way over the size.
  const double turn = 3 * kAlong * kStep / kSize;
  EXPECT_NEAR(world.bodies[0].velocity.y(), -push / kBall, turn * push / kBall * kMu);
  EXPECT_NEAR(world.bodies[0].velocity.x(), kMu * push / kBall, turn * push / kBall);
  const double inertia = 0.4 * kBall * kSize * kSize;
  EXPECT_NEAR(world.bodies[0].spin.z(), -kMu * push * kSize / inertia,
              turn * push * kSize / inertia);
}

/// A net in space, in a horizontal plane, that a ball flies into from above.
World ball_and_net(double friction) {
  World world = joined_worlds::net(9, 0.4);
  world.gravity.setZero();
  Vec3 middle = Vec3::Zero();
  double count = 0;
  for (Connector& cord : world.connectors) {
    cord.holds.clear();
    cord.radius = kThick;
    for (const Vec3& at : cord.position) middle += at, ++count;
  }
  const Vec3 along = world.connectors.front().position[1] - world.connectors.front().position[0];
  const Vec3 across = world.connectors.back().position[1] - world.connectors.back().position[0];
  const Vec3 normal = along.cross(across).normalized();
  world.bodies = {large_ball(middle / count + 0.2 * normal, -2 * normal)};
  touch(world, friction, 0);
  world.topology = 0;
  finish(world);
  return world;
}

TEST_P(BeadsOfNets, MomentumStaysWhereABallFliesIntoANet) {
  for (const double friction : {0.0, 0.5}) {
    const World start = ball_and_net(friction);
    Simulation simulation = simulate(start);
    bool met = false;
    for (int frame = 1; frame <= 20; ++frame) {
      simulation.advance_to(frame / 60.0);
      const World& world = simulation.world();
      EXPECT_LT((linear_momentum(world) - linear_momentum(start)).norm(), 1e-13 / kStep) << frame;
      EXPECT_LE(depth_in_ball(world), 1e-9);
      EXPECT_LT(energy(world), (1 + 1e-9) * energy(start)) << frame;
      met = met || world.bodies[0].velocity.norm() < 1.99;
    }
    EXPECT_TRUE(met);
  }
}

/// A cord of four beads that comes at a ball with the last.
World cord_comes_at_ball() {
  World start;
  start.gravity.setZero();
  Connector cord = straight_connector("cord", 0.6, 4 * kBead, 4, Vec3(0, 0.1, 0), Vec3::UnitZ());
  cord.radius = kThick;
  for (Vec3& velocity : cord.velocity) velocity = Vec3(0, -1, 0);
  start.connectors = {cord};
  start.bodies = {large_ball(Vec3(0, 0, 0.6))};
  touch(start);
  finish(start);
  return start;
}

TEST_P(BeadPairs, WhatIsCutOffTouchesAsBefore) {
  Simulation simulation(cord_comes_at_ball(), make_method(GetParam(), {{"step", kStep}}),
                        Timeline{.pins = {}, .cuts = {{0, 0.4, 0.01}}});
  const double meets = 0.1 - kThick - kSize, later = 0.004, turned = later / 0.2;
  simulation.advance_to(meets + later);
  EXPECT_NEAR(simulation.world().bodies[0].velocity.y(), -1 / (1 + kBall / kBead),
              turned * turned / (1 + kBall / kBead));
}

// A pin takes the bead that touches, the last of those that may.
TEST_P(BeadPairs, WhatIsPinnedWhileItTouchesIsLeft) {
  const double meets = 0.1 - kThick - kSize;
  Simulation simulation(cord_comes_at_ball(), make_method(GetParam(), {{"step", kStep}}),
                        Timeline{.pins = {{0, 0.6, meets + kStep, INFINITY, {}}}, .cuts = {}});
  simulation.advance_to(meets + 2 * kStep);
  const Vec3 velocity = simulation.world().bodies[0].velocity;
  EXPECT_LT(velocity.y(), 0);
  simulation.advance_to(0.3);
  EXPECT_EQ(simulation.world().connectors[0].velocity.back().norm(), 0);
  EXPECT_LT((simulation.world().bodies[0].velocity - velocity).norm(), 1e-15 / kStep);
}

// Held at its corners, the net carries the ball, which has lost nearly all of what it fell by.
TEST_P(BeadsOfNets, ABallComesToRestInANet) {
  World world = joined_worlds::net(9, 0.4);
  Vec3 middle = Vec3::Zero();
  for (Connector& cord : world.connectors) cord.radius = kThick;
  for (Connector& cord : world.connectors) cord.holds.clear();
  for (const std::size_t c : {0u, 8u}) {
    Connector& cord = world.connectors[c];
    for (const std::size_t p : {std::size_t{0}, cord.links()}) {
      cord.holds.push_back({p, worlds::fixed_at(cord.position[p])});
      middle += cord.position[p] / 4;
    }
  }
  world.bodies = {large_ball(middle + 0.15 * Vec3::UnitY())};
  touch(world, 0.5);
  world.topology = 0;
  finish(world);
  const World rest = after(world, 9);
  const double fallen = world.bodies[0].position.y() - rest.bodies[0].position.y();
  EXPECT_LT(fallen, 0.15 + 0.4) << "it fell through";
  EXPECT_LE(depth_in_ball(rest), 1e-9);
  EXPECT_LT(rest.bodies[0].velocity.squaredNorm() / 2, 1e-3 * kGravity * fallen);
}

// Joined beads touch obstacles, too; of two that are joined one stands for both.
TEST_P(BeadsOfNets, ANetFallsOnAFloor) {
  World world = joined_worlds::net(5, 0.3);
  for (Connector& cord : world.connectors) {
    cord.holds.clear();
    cord.radius = kThick;
    for (Vec3& at : cord.position) at.y() += 0.1;
  }
  world.obstacles = {obstacle(plane_shape(), 0.5)};
  world.topology = 0;
  finish(world);
  const World rest = after(world, 4);
  for (const Connector& cord : rest.connectors) {
    for (const Vec3& at : cord.position) EXPECT_GE(at.y(), kThick - 1e-9);
  }
  EXPECT_LT(fastest(rest), kGain);
}

INSTANTIATE_TEST_SUITE_P(All, BeadPairs, testing::Values("xpbd", "springs", "direct"));
INSTANTIATE_TEST_SUITE_P(AsGamesDo, BeadsOfNets, testing::Values("xpbd", "springs"));

TEST(BeadPairs, OthersRefuseThemByName) {
  for (const MethodInfo& method : all_methods()) {
    if (method.abilities.follows.has(Feature::bead_pairs) || !method.missing.empty()) continue;
    const World world = bead_meets_ball(Vec3::UnitY(), -Vec3::UnitY(), 0, 0);
    EXPECT_FALSE(refusal(method, world).empty());
    Simulation simulation(world, make_method(method.name, {}));
    EXPECT_THROW(simulation.advance_to(0.01), Diverged) << method.name;
  }
}

}  // namespace
}  // namespace taut::bead_pairs_test
