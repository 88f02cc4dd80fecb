// Free bodies at obstacles, by the direct method and by the truth: sticks whose motion is known
// beforehand.
#include <gtest/gtest.h>

#include <numbers>

#include "contact_sticks.h"
#include "sim/measure/measure.h"

namespace taut::contact_body_test {
namespace {

using namespace contact_sticks;

class ContactBody : public testing::TestWithParam<const char*> {
 protected:
  bool is_truth() const { return std::string(GetParam()) == "truth"; }
  Simulation simulate(const World& world, double tolerance = 1e-4) const {
    const Settings settings = is_truth() ? Settings{} : Settings{{"tolerance", tolerance}};
    return {world, make_method(GetParam(), settings)};
  }
};

// J = (1 + e) m v / (1 + 3 cos^2 a), at the end that strikes.
TEST_P(ContactBody, ARodOnOneEndByTheClosedForm) {
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const double angle : {0.3, 0.8, 1.4}) {
      const double lands = 0.25, speed = kGravity * lands;
      const double height = kRadius + kLength / 2 * std::sin(angle) + speed * lands / 2;
      Simulation simulation =
          simulate(with(leaning(Vec3(0, height, 0), angle), obstacle(plane_shape(), 0, e)));
      simulation.advance_to(lands + 1e-9);
      const double impulse = (1 + e) * kMass * speed / (1 + 3 * std::cos(angle) * std::cos(angle));
      const Body& body = simulation.world().bodies[0];
      // Gravity for a nanosecond and what is located to 1e-8 m are less.
      EXPECT_NEAR(body.velocity.y(), impulse / kMass - speed, 1e-7) << e << " " << angle;
      EXPECT_NEAR(body.velocity.x(), 0, 1e-12);
      EXPECT_NEAR(body.spin.z(), -impulse * kLength / 2 * std::cos(angle) / kAcross, 1e-6)
          << e << " " << angle;
    }
  }
}

// With friction that sticks the end stops: the rod turns about it, with w = 3 v cos(a)/2l.
TEST_P(ContactBody, ARodOnOneEndThatSticks) {
  const double angle = 0.8, lands = 0.25, speed = kGravity * lands;
  const double height = kRadius + kLength / 2 * std::sin(angle) + speed * lands / 2;
  Body body = leaning(Vec3(0, height, 0), angle);
  body.capsule.radius = 1e-6;  // else friction acts beside the end
  body.position.y() += 1e-6 - kRadius;
  Simulation simulation = simulate(with(body, obstacle(plane_shape(), 2)));
  simulation.advance_to(lands + 1e-9);
  const double spin = 1.5 * speed * std::cos(angle) / kLength;
  EXPECT_NEAR(simulation.world().bodies[0].spin.z(), -spin, 1e-4 * spin);  // of the radius
}

TEST_P(ContactBody, WhatLiesStaysAtRest) {
  Obstacle box = obstacle(box_shape(Vec3(0.2, 0.1, 0.1)), 0.4);
  box.place.position.y() = -0.05;
  for (const Obstacle& below : {obstacle(plane_shape(), 0.4), obstacle(plane_shape(), 0), box}) {
    Simulation simulation = simulate(with(leaning(Vec3(0, kRadius, 0), 0), below));
    simulation.advance_to(is_truth() ? 1 : 10);
    const Body& body = simulation.world().bodies[0];
    EXPECT_LT(body.velocity.norm(), 1e-9);
    EXPECT_LT(body.spin.norm(), 1e-9);
    EXPECT_NEAR(body.position.y(), kRadius, 1e-9 * kLength);
    EXPECT_LE(depth(simulation.world()), 1e-9 * kLength);
  }
}

TEST_P(ContactBody, ARodOnAnInclineSlidesOrSticks) {
  const double angle = std::atan(0.5);
  for (const double mu : {0.0, 0.2, 0.6}) {
    const Vec3 up(-std::sin(angle), std::cos(angle), 0);
    Simulation simulation = simulate(with(leaning(kRadius * up, angle), incline(angle, mu)));
    simulation.advance_to(1);
    const double down = kGravity * (std::sin(angle) - mu * std::cos(angle));
    const Body& body = simulation.world().bodies[0];
    EXPECT_NEAR((body.position - kRadius * up).norm(), std::max(0.0, down / 2), 1e-10) << mu;
    EXPECT_LE(depth(simulation.world()), 1e-9 * kLength);
  }
}

// Pushed up an incline it stops after v^2/2a, and stays there.
TEST_P(ContactBody, ARodStopsWhereItMust) {
  constexpr double speed = 2, kinetic = 0.3;
  const double angle = std::atan(0.5);
  const Vec3 along(std::cos(angle), std::sin(angle), 0);
  Simulation simulation = simulate(rod_pushed_up(angle, speed, kinetic));
  simulation.advance_to(2);
  const double slowing = kGravity * (std::sin(angle) + kinetic * std::cos(angle));
  const double way = simulation.world().bodies[0].position.dot(along);
  // direct: the tolerance, its last step is too long.
  EXPECT_NEAR(way, speed * speed / (2 * slowing), is_truth() ? 1e-10 : 1e-4);
  EXPECT_LT(simulation.world().bodies[0].velocity.norm(), 1e-9);
}

// Across the slope it rolls: x'' = g sin(a)/(1 + I/m r^2), with two thirds of g sin(a).
TEST_P(ContactBody, ARodThatLiesAcrossAnInclineRolls) {
  const double angle = 0.2;
  const Vec3 along(std::cos(angle), std::sin(angle), 0), up(-along.y(), along.x(), 0);
  Body body = leaning(kRadius * up, angle);
  body.rotation = rotation_between(Vec3::UnitY(), Vec3::UnitZ());
  Simulation simulation = simulate(with(body, incline(angle, 0.5)));
  constexpr double time = 0.5;
  simulation.advance_to(time);
  const double way = kGravity * std::sin(angle) / 1.5 * time * time / 2;
  EXPECT_NEAR(-simulation.world().bodies[0].position.dot(along), way, is_truth() ? 1e-9 : 1e-4);
}

// The rod's centre falls straight down, and energy gives the spin by the angle until it lies flat.
TEST_P(ContactBody, ARodThatSlipsOnASmoothFloor) {
  const double start = 1.2, half = kLength / 2;
  const World world =
      with(leaning(Vec3(0, kRadius + half * std::sin(start), 0), start), obstacle(plane_shape()));
  Simulation simulation = simulate(world, 1e-6);
  const double at_start = energy(world);
  for (int frame = 1; frame <= 20; ++frame) {
    simulation.advance_to(frame / 60.0);
    const Body& body = simulation.world().bodies[0];
    const double height = body.position.y() - kRadius;
    EXPECT_LE(depth(simulation.world()), 1e-9 * kLength);
    if (height < 0.01) break;
    const double sine = height / half, square = 1 - sine * sine;
    const double turns = std::sqrt(2 * kMass * kGravity * half * (std::sin(start) - sine) /
                                   (kMass * half * half * square + kAcross));
    const double slack = is_truth() ? 1e-8 : 1e-3;
    EXPECT_NEAR(-body.spin.z(), turns, slack * turns) << frame;
    EXPECT_NEAR(body.position.x(), 0, 1e-12);
    EXPECT_LT(energy(simulation.world()), at_start + (is_truth() ? 1e-9 : 1e-6));
  }
}

/// A stick on a rope that swings against a post.
World swinging_stick(double friction, double restitution = 0) {
  World world = worlds::chain(7, 0.6, Vec3::UnitX(), 0.05);
  Body stick = leaning(Vec3::Zero(), 0);
  stick.position = Vec3(0.6 + kLength / 2, 0, 0);
  world.bodies = {stick};
  world.connectors[0].holds.push_back({6, worlds::on_body(0, kLength / 2 * Vec3::UnitY())});
  world.bodies[0].rotation = Quat(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()));
  Obstacle with = post(0.05, Vec3(0.1, -0.9, 0), friction);
  with.restitution = restitution;
  world.obstacles = {with};
  finish(world);
  return world;
}

TEST(ContactBodies, TwoSolversAgree) {
  for (const double friction : {0.0, 0.3}) {
    const World world = swinging_stick(friction);
    Simulation truth(world, make_method("truth", {}));
    truth.advance_to(0.7);
    EXPECT_LE(depth(truth.world()), 1e-11);
    double before = 0;
    for (const double step : {4e-4, 2e-4, 1e-4}) {
      Simulation other(world, make_method("direct", {{"step", step}}));
      other.advance_to(0.7);
      EXPECT_LE(depth(other.world()), 1e-9 * kLength);
      const Body &a = truth.world().bodies[0], &b = other.world().bodies[0];
      const double error =
          (a.position - b.position).norm() + kLength / 2 * a.rotation.angularDistance(b.rotation);
      if (before > 0) {
        EXPECT_LT(error, 0.7 * before);
      }
      before = error;
    }
    EXPECT_LT(before, 1e-4);
  }
}

INSTANTIATE_TEST_SUITE_P(Both, ContactBody, testing::Values("direct", "truth"));

}  // namespace
}  // namespace taut::contact_body_test
