// Features together by the direct method, against answers that are known.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "sim/world/obstacle.h"
#include "sim/world/winched.h"
#include "tests/physics/worlds.h"

namespace taut::together_test {
namespace {

constexpr double kRadius = 0.01;  // m, of a bead

Obstacle floor_at(double height, double friction = 0, double restitution = 0) {
  Obstacle floor;
  floor.name = "floor";
  floor.shape = plane_shape();
  floor.place.position.y() = height;
  floor.static_friction = floor.kinetic_friction = friction;
  floor.restitution = restitution;
  return floor;
}

/// A bead of 1 kg on a massless spring of one link, which is fixed at the origin.
World bead_on_spring(double stiffness, double rest, const Vec3& bead) {
  World world;
  Connector spring = straight_connector("spring", rest, 0, 2, Vec3::Zero(), bead.normalized());
  spring.position[1] = bead;
  spring.particle_mass = {0, 1};
  spring.radius = kRadius;
  spring.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  spring.sections.assign(1, Section{});
  spring.sections[0].axial_stiffness = stiffness * rest;
  world.connectors = {spring};
  return world;
}

Simulation by_direct(const World& world, double tolerance) {
  return Simulation(world, make_method("direct", {{"tolerance", tolerance}}));
}

// Coulomb's friction takes 4 mu m g/k from the swing of a mass on a spring in each period, and
// holds it once the spring pulls by less.
TEST(Together, ASpringPullsABeadOverARoughFloor) {
  constexpr double kStiffness = 100, kRest = 1, kPulled = 0.35, kFriction = 0.4;
  const double dead = kFriction * worlds::kGravity / kStiffness;
  World world = bead_on_spring(kStiffness, kRest, Vec3(kRest + kPulled, 0, 0));
  world.obstacles = {floor_at(-kRadius, kFriction)};
  finish(world);
  for (const double tolerance : {1e-3, 1e-5}) {
    Simulation simulation = by_direct(world, tolerance);
    const double half = std::numbers::pi / std::sqrt(kStiffness);
    double turn = kPulled;
    for (int i = 1; std::abs(turn) > dead; ++i) {
      simulation.advance_to(i * half);
      turn = turn > 0 ? -turn + 2 * dead : -turn - 2 * dead;
      EXPECT_NEAR(simulation.world().connectors[0].position[1].x(), kRest + turn, tolerance) << i;
    }
    simulation.advance_to(5);
    EXPECT_NEAR(simulation.world().connectors[0].position[1].x(), kRest + turn, tolerance);
    EXPECT_LT(simulation.world().connectors[0].velocity[1].norm(), tolerance);
  }
}

// Between two impacts a weight on a spring swings about its place of rest, a height `kOver` above
// the floor; an impact leaves the share e of its speed.
TEST(Together, AWeightOnASpringBounces) {
  constexpr double kStiffness = 50, kRest = 1, kSwing = 0.3, kOver = 0.1, kBounce = 0.8;
  const double rate = std::sqrt(kStiffness), sag = worlds::kGravity / kStiffness;
  World world = bead_on_spring(kStiffness, kRest, Vec3(0, -(kRest + sag) + kSwing, 0));
  world.obstacles = {floor_at(-(kRest + sag) - kOver - kRadius, 0, kBounce)};
  finish(world);
  for (const double tolerance : {1e-3, 1e-5}) {
    Simulation simulation = by_direct(world, tolerance);
    double swing = kSwing, time = 0;
    for (int i = 0; i < 3; ++i) {
      time += std::acos(-kOver / swing) / rate;
      const double speed = kBounce * rate * std::sqrt(swing * swing - kOver * kOver);
      swing = std::hypot(kOver, speed / rate);
      time += std::acos(-kOver / swing) / rate;
      simulation.advance_to(time);
      EXPECT_NEAR(simulation.world().connectors[0].position[1].y(), -(kRest + sag) + swing,
                  tolerance)
          << i;
    }
  }
}

// A cantilever under its own weight w would sag by w L^4/8EI; a floor at the depth d under its
// clamp carries R = 3EI/L^3 (w L^4/8EI - d) of its end.
TEST(Together, AFloorCarriesTheEndOfABentRope) {
  constexpr double kLength = 1, kStiffness = 1, kWeight = 0.1;
  constexpr double kDepth = 0.5 * kWeight / 8;
  constexpr std::size_t kParticles = 41;
  World world;
  Connector rope = straight_connector("rope", kLength, kWeight / worlds::kGravity, kParticles,
                                      Vec3::Zero(), Vec3::UnitX());
  rope.radius = 1e-3;
  rope.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  rope.holds[0].clamp = Vec3::UnitX();
  Section section;
  section.bending_stiffness = kStiffness;
  section.bending_damping = 0.02;
  section.diameter = 2e-3;
  rope.sections.assign(kParticles - 1, section);
  world.connectors = {rope};
  world.obstacles = {floor_at(-kDepth - rope.radius)};
  finish(world);
  Simulation simulation = by_direct(world, 1e-6);
  simulation.advance_to(2);
  const double carried = 3 * kStiffness * (kWeight / 8 / kStiffness - kDepth);
  for (const std::size_t i : {kParticles / 4, kParticles / 2, 3 * kParticles / 4}) {
    const Vec3& at = simulation.world().connectors[0].position[i];
    const double x = at.x();
    const double sag =
        (kWeight * x * x * (6 - 4 * x + x * x) / 24 - carried * x * x * (3 - x) / 6) / kStiffness;
    EXPECT_NEAR(at.y(), -sag, 0.02 * kDepth) << i;
  }
}

// A winch lets a weight on a rope of strings down to a rough floor, where it lies.
TEST(Together, AWinchLetsAWeightDown) {
  World world;
  Connector rope = straight_connector("rope", 1, 0.05, 11, Vec3::Zero(), -Vec3::UnitY());
  rope.radius = kRadius;
  rope.pulls = true;
  rope.particle_mass.back() = 1;
  rope.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  std::vector<PathKey> keys(2);
  keys[1].time = 2;
  keys[1].position.x() = 0.3;
  for (PathKey& key : keys) key.ease = true;
  world.connectors = {rope};
  world.obstacles = {floor_at(-1.2, 0.5)};
  finish(world);
  add_winches(world, world.connectors[0], std::make_shared<const Path>(keys), nullptr);
  finish(world);
  Simulation simulation = by_direct(world, 1e-4);
  simulation.advance_to(0.8);
  const double s = 0.4, paid = 0.3 * s * s * s * (10 - 15 * s + 6 * s * s);
  EXPECT_NEAR(simulation.world().connectors[0].position.back().y(), -1 - paid, 2e-4);
  simulation.advance_to(2.5);
  EXPECT_NEAR(simulation.world().connectors[0].position.back().y(), -1.2 + kRadius, 2e-4);
}

// A weight falls on a massless cord over a floor, and the cord throws it back with half of its
// speed.
TEST(Together, AMasslessCordSnapsOverAFloor) {
  constexpr double kLength = 0.7, kSlack = 0.5, kBack = 0.5;
  World world;
  Connector cord = straight_connector("cord", kLength, 0, 2, Vec3::Zero(), -Vec3::UnitY());
  cord.model = ConnectorModel::span;
  cord.restitution = kBack;
  cord.particle_mass = {0, 1};
  cord.position[1].y() = kSlack - kLength;
  cord.radius = kRadius;
  cord.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  world.connectors = {cord};
  world.obstacles = {floor_at(-2 * kLength, 0.3)};
  finish(world);
  const double fall = std::sqrt(2 * kSlack / worlds::kGravity), speed = fall * worlds::kGravity;
  for (const double tolerance : {1e-3, 1e-5}) {
    Simulation simulation = by_direct(world, tolerance);
    simulation.advance_to(fall + kBack * speed / worlds::kGravity);
    EXPECT_NEAR(simulation.world().connectors[0].position[1].y(), -kLength + kBack * kBack * kSlack,
                tolerance);
    simulation.advance_to(5);
    EXPECT_NEAR(simulation.world().connectors[0].position[1].y(), -kLength, tolerance);
  }
}

Body ball(const char* name, double mass, double radius, const Vec3& at) {
  Body made;
  made.name = name;
  made.mass_properties = solid_sphere(mass, radius);
  made.position = at;
  made.capsule.radius = radius;
  return made;
}

// A body slides up a slope, stops by friction, and slides back.
TEST(Together, ABodySlidesUpASlopeAndBack) {
  constexpr double kSlope = std::numbers::pi / 6, kFriction = 0.25, kSpeed = 1.7;
  World world;
  world.gravity = worlds::kGravity * Vec3(-std::sin(kSlope), -std::cos(kSlope), 0);
  Body body = ball("puck", 0.2, kRadius, Vec3(0, kRadius, 0));
  body.mass_properties.inertia = 1e3 * Mat3::Identity();  // it does not roll
  body.velocity.x() = kSpeed;
  world.bodies = {body};
  world.obstacles = {floor_at(0, kFriction)};
  finish(world);
  const double up = worlds::kGravity * (std::sin(kSlope) + kFriction * std::cos(kSlope)),
               down = worlds::kGravity * (std::sin(kSlope) - kFriction * std::cos(kSlope));
  const double stop = kSpeed / up;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5}) {
    Simulation simulation = by_direct(world, tolerance);
    simulation.advance_to(1);
    EXPECT_NEAR(simulation.world().bodies[0].position.x(),
                kSpeed * stop / 2 - down * (1 - stop) * (1 - stop) / 2, 0.1 * tolerance);
  }
}

// A ball swings down on a rope, from level, and meets a smooth floor that stops it without a
// bounce. On light strings it slides on as fast as it went along the floor. A straight chain of
// rods is a strut: it stops the ball, but for as much as the rods buckle.
TEST(Together, ABallOnALightRopeLandsAndSlides) {
  constexpr double kLength = 0.5, kBall = 0.05, kDrop = 0.25, kSlides = 0.3;
  constexpr int kParts = 1000;
  const double turned = std::asin(kDrop / kLength);
  double lands = 0;  // s: the integral of the angle over its rate, with the angle as a square
  for (int i = 0; i < kParts; ++i) {
    const double root = (i + 0.5) / kParts * std::sqrt(turned);
    lands += 2 * root * std::sqrt(turned) / kParts /
             std::sqrt(2 * worlds::kGravity / kLength * std::sin(root * root));
  }
  const double speed = std::sqrt(2 * worlds::kGravity * kDrop) * std::sin(turned);
  for (const double share : {1e-4, 1e-5, 1e-6}) {
    for (const bool pulls : {true, false}) {
      World world;
      Connector rope = straight_connector("rope", kLength, share, 11, Vec3::Zero(), Vec3::UnitX());
      rope.pulls = pulls;
      rope.holds = {{0, worlds::fixed_at(Vec3::Zero())}, {10, worlds::on_body(0, Vec3::Zero())}};
      world.connectors = {rope};
      world.bodies = {ball("ball", 1, kBall, kLength * Vec3::UnitX())};
      world.obstacles = {floor_at(-kDrop - kBall)};
      finish(world);
      Simulation simulation = by_direct(world, 1e-3);
      simulation.advance_to(lands + kSlides);
      const Vec3 at = simulation.world().bodies[0].position;
      const double landed = kLength * std::cos(turned), slid = landed - kSlides * speed;
      EXPECT_NEAR(at.x(), slid, pulls ? 1e-3 : landed - slid) << share;
      EXPECT_LT(energy(simulation.world()), energy(world));
      EXPECT_NEAR(at.y(), -kDrop, 1e-3) << share;
    }
  }
}

/// A rope that bends, clamped to a free body at the origin, without gravity. It starts straight,
/// with its tip thrown aside.
World clamped_to_body(double mass, double inertia) {
  World world;
  world.gravity = Vec3::Zero();
  Body body;
  body.name = "hub";
  body.mass_properties.mass = mass;
  body.mass_properties.inertia = inertia * Mat3::Identity();
  world.bodies = {body};
  const Vec3 grip(0.02, 0, 0);
  Connector rope = straight_connector("rope", 0.5, 0.1, 11, grip, Vec3::UnitX());
  rope.holds = {{0, worlds::on_body(0, grip)}};
  rope.holds[0].clamp = Vec3::UnitX();
  Section section;
  section.bending_stiffness = 0.05;
  section.diameter = 0.01;
  rope.sections.assign(rope.links(), section);
  for (std::size_t i = 1; i <= 10; ++i) {
    rope.velocity[i] = 0.01 * static_cast<double>(i * i) * Vec3(0, 1, 0.5);
  }
  world.connectors = {rope};
  finish(world);
  return world;
}

// A body so heavy that nothing moves it clamps a rope as a fixed place does.
TEST(Together, AHeavyBodyClampsLikeAWall) {
  const World on_body = clamped_to_body(1e9, 1e9);
  World at_wall = on_body;
  at_wall.bodies.clear();
  at_wall.connectors[0].holds[0].to = worlds::fixed_at(on_body.connectors[0].position[0]);
  finish(at_wall);
  Simulation first = by_direct(on_body, 1e-5), second = by_direct(at_wall, 1e-6);
  for (const double time : {0.1, 0.2, 0.4}) {
    first.advance_to(time);
    second.advance_to(time);
    for (std::size_t i = 0; i <= 10; ++i) {
      const Vec3 apart =
          first.world().connectors[0].position[i] - second.world().connectors[0].position[i];
      EXPECT_LT(apart.norm(), 1e-5) << time << " " << i;
    }
  }
}

// A light body turns with the rope that is clamped to it; nothing else takes their momenta.
TEST(Together, AClampedBodyTurnsWithTheRope) {
  const auto momenta = [](const World& world) {
    const Body& body = world.bodies[0];
    const Mat3 turn = body.rotation.toRotationMatrix();
    Vec3 linear = body.mass_properties.mass * body.velocity;
    Vec3 angular = body.position.cross(linear) +
                   turn * body.mass_properties.inertia * turn.transpose() * body.spin;
    const Connector& rope = world.connectors[0];
    for (std::size_t i = 1; i < rope.particles(); ++i) {
      linear += rope.particle_mass[i] * rope.velocity[i];
      angular += rope.particle_mass[i] * rope.position[i].cross(rope.velocity[i]);
    }
    return std::pair(linear, angular);
  };
  const World start = clamped_to_body(0.05, 5e-5);
  Simulation simulation = by_direct(start, 1e-5);
  simulation.advance_to(0.5);
  const World& end = simulation.world();
  EXPECT_GT(end.bodies[0].spin.norm(), 0.1);
  EXPECT_LT((momenta(end).first - momenta(start).first).norm(), 1e-4 * momenta(start).first.norm());
  EXPECT_LT((momenta(end).second - momenta(start).second).norm(),
            1e-4 * momenta(start).second.norm());
  EXPECT_NEAR(energy(end), energy(start), 1e-4 * energy(start));
}

// A rod that bends is thrown on a floor; it bounces with all of its speed, and rubs.
TEST(Together, ABouncingBentRopeGainsNoEnergy) {
  for (const double friction : {0.0, 0.3, 1.0}) {
    World world;
    Connector rope =
        straight_connector("rope", 0.5, 0.2, 11, Vec3(0, 0.6, 0), worlds::from_down(50));
    rope.radius = kRadius;
    Section section;
    section.bending_stiffness = 0.02;
    section.diameter = 2 * kRadius;
    rope.sections.assign(rope.links(), section);
    for (Vec3& velocity : rope.velocity) velocity = Vec3(0.5, -1, 0.2);
    world.connectors = {rope};
    world.obstacles = {floor_at(0, friction, 1)};
    finish(world);
    const double start = energy(world);
    Simulation simulation = by_direct(world, 1e-4);
    double most = 0;
    for (int frame = 1; frame <= 30; ++frame) {
      simulation.advance_to(frame / 30.0);
      most = std::max(most, energy(simulation.world()) - start);
    }
    EXPECT_LT(most, 1e-4 * start) << friction;
  }
}

}  // namespace
}  // namespace taut::together_test
