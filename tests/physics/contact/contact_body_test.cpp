// Free bodies at obstacles, by the direct method and by the truth: what lies at rest, and two
// solvers on a stick that swings. tests/answers has those whose motion is known beforehand.
#include <gtest/gtest.h>

#include <numbers>

#include "contact_sticks.h"

namespace taut::contact_body_test {
namespace {

using namespace contact_sticks;

class ContactBody : public testing::TestWithParam<const char*> {
 protected:
  bool is_truth() const { return std::string(GetParam()) == "truth"; }
  Simulation simulate(const World& world) const { return {world, make_method(GetParam(), {})}; }
};

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
