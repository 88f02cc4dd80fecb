// Free bodies that touch, as games do it, in xpbd and springs: of first order in the step.
#include <gtest/gtest.h>

#include "contact_sticks.h"
#include "sim/measure/measure.h"

namespace taut::body_contacts_test {
namespace {

using namespace contact_sticks;

constexpr double kStep = 1.0 / 3840;        // s
constexpr double kGain = kGravity * kStep;  // m/s, of speed in a step

class BodiesByGames : public testing::TestWithParam<const char*> {
 protected:
  Simulation simulate(const World& start, double step = kStep) const {
    return {start, make_method(GetParam(), {{"step", step}})};
  }
  World after(const World& start, double time, double step = kStep) const {
    Simulation simulation = simulate(start, step);
    simulation.advance_to(time);
    return simulation.world();
  }
};

/// How far the bodies of two worlds are from each other, and turned by (m).
double apart(const World& a, const World& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    sum += (a.bodies[i].position - b.bodies[i].position).norm() +
           kLength / 2 * a.bodies[i].rotation.angularDistance(b.bodies[i].rotation);
  }
  return sum;
}

World by_direct(const World& start, double time) {
  Simulation simulation = contact_worlds::by_direct(start, 1e-6);
  simulation.advance_to(time);
  return simulation.world();
}

// Flat, aslant or on its end. What is moved out turns by its depth over its length, and the square
// of that is left.
TEST_P(BodiesByGames, WhatFallsComesToRest) {
  const double upright = std::numbers::pi / 2, fall = 0.2, speed = std::sqrt(2 * kGravity * fall);
  for (const double angle : {0.0, 0.1, 1.0, upright}) {
    for (const double e : {0.0, 0.5}) {
      const double height = kRadius + kLength / 2 * std::sin(angle);
      Simulation simulation = simulate(
          with(leaning(Vec3(0, fall + height, 0), angle), obstacle(plane_shape(), 0.4, e)));
      // Balance on an end is unstable.
      for (int frame = 1; frame <= (angle == upright ? 75 : 240); ++frame) {
        simulation.advance_to(frame / 60.0);
        EXPECT_LE(depth(simulation.world()), std::pow(2 * speed * kStep, 2) / kLength) << angle;
      }
      const Body& body = simulation.world().bodies[0];
      EXPECT_LT(body.velocity.norm() + kLength / 2 * body.spin.norm(), kGain) << angle << " " << e;
      EXPECT_NEAR(body.position.y(), angle == upright ? height : kRadius, 2 * kGain * kStep);
    }
  }
}

TEST_P(BodiesByGames, ARodOnAnInclineSlidesOrSticks) {
  const double angle = std::atan(0.5);
  for (const double mu : {0.0, 0.2, 0.6}) {
    const Vec3 up(-std::sin(angle), std::cos(angle), 0);
    const World world = after(with(leaning(kRadius * up, angle), incline(angle, mu)), 1);
    const double down = kGravity * (std::sin(angle) - mu * std::cos(angle));
    EXPECT_NEAR((world.bodies[0].position - kRadius * up).norm(), std::max(0.0, down / 2),
                2 * kStep * kGravity)
        << mu;
  }
}

// Pushed up an incline it stops after v^2/2a, as it may be off by a step's gravity all the way.
TEST_P(BodiesByGames, ARodStopsWhereItMust) {
  constexpr double speed = 2, kinetic = 0.3;
  const double angle = std::atan(0.5);
  const Vec3 along(std::cos(angle), std::sin(angle), 0);
  const World world = after(rod_pushed_up(angle, speed, kinetic), 1);
  const double slowing = kGravity * (std::sin(angle) + kinetic * std::cos(angle));
  EXPECT_NEAR(world.bodies[0].position.dot(along), speed * speed / (2 * slowing), kGain);
  EXPECT_LT(world.bodies[0].velocity.norm(), kGain);
}

// Across the slope it rolls: x'' = g sin(a)/(1 + I/m r^2), with two thirds of g sin(a).
TEST_P(BodiesByGames, ARodThatLiesAcrossAnInclineRolls) {
  const double angle = 0.2, time = 0.5;
  const Vec3 along(std::cos(angle), std::sin(angle), 0), up(-along.y(), along.x(), 0);
  Body body = leaning(kRadius * up, angle);
  body.rotation = rotation_between(Vec3::UnitY(), Vec3::UnitZ());
  const World world = after(with(body, incline(angle, 0.5)), time);
  const double way = kGravity * std::sin(angle) / 1.5 * time * time / 2;
  EXPECT_NEAR(-world.bodies[0].position.dot(along), way, kGain * time);
}

// J = (1 + e) m v / (1 + 3 cos^2 a), at the end that strikes, up to a step late.
TEST_P(BodiesByGames, ARodOnOneEndByTheClosedForm) {
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const double angle : {0.3, 0.8, 1.4}) {
      const double lands = 0.25, speed = kGravity * lands;
      const double height = kRadius + kLength / 2 * std::sin(angle) + speed * lands / 2;
      const World world = after(
          with(leaning(Vec3(0, height, 0), angle), obstacle(plane_shape(), 0, e)), lands + kStep);
      const double impulse = (1 + e) * kMass * speed / (1 + 3 * std::cos(angle) * std::cos(angle));
      const Body& body = world.bodies[0];
      EXPECT_NEAR(body.velocity.y(), impulse / kMass - speed, 3 * kGain) << e << " " << angle;
      EXPECT_NEAR(body.velocity.x(), 0, 1e-12);
      EXPECT_NEAR(kLength / 2 * body.spin.z(), -3 * impulse / kMass * std::cos(angle), 6 * kGain)
          << e << " " << angle;
    }
  }
}

// A plate lifts a rod and carries it aside; its path leads it by less than g.
TEST_P(BodiesByGames, APlateCarriesARod) {
  Obstacle plate = obstacle(box_shape(Vec3(0.6, 0.02, 0.6)), 0.8);
  plate.place.position.y() = -0.01;
  const Vec3 way(0.2, 0.3, 0);
  plate.path = std::make_shared<const Path>(std::vector<PathKey>{
      {0, Vec3::Zero(), Quat::Identity(), true}, {1, way, Quat::Identity(), true}});
  const World world = after(with(leaning(Vec3(0, kRadius, 0), 0.0), plate), 1.2);
  EXPECT_LT((world.bodies[0].position - way - kRadius * Vec3::UnitY()).norm(), 1.2 * kGain);
  EXPECT_LT(world.bodies[0].velocity.norm(), kGain);
}

// End to end, and side by side: momentum stays, and they part as fast as e says.
TEST_P(BodiesByGames, EqualOnesHeadOn) {
  constexpr double kSpeed = 2;
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const Vec3& way : {Vec3(Vec3::UnitY()), Vec3(Vec3::UnitX())}) {
      const Vec3 between = (kLength + 0.1) * way;
      const World start = among({rod(-between, kSpeed * way), rod(between)}, 0.4, e);
      const World world = after(start, 0.6);
      const Body &a = world.bodies[0], &b = world.bodies[1];
      // Positions of a metre are rounded, and their changes in a step make velocities.
      EXPECT_LT((linear_momentum(world) - linear_momentum(start)).norm(), 1e-15 / kStep);
      EXPECT_NEAR((b.velocity - a.velocity).dot(way), e * kSpeed, 1e-8 * kSpeed) << e;
      EXPECT_LT(kLength / 2 * (a.spin.norm() + b.spin.norm()), 1e-8 * kSpeed);
      EXPECT_LE(depth(world), 1e-8 * kSpeed * kStep);
    }
  }
}

// J = (1 + e) v/(1/m + 1/m + l^2/I + d^2/I): an end of one at a distance d from the other's middle.
// What is moved out turns them by a thousandth before they part.
TEST_P(BodiesByGames, AnEndHitsBesideTheMiddle) {
  constexpr double kSpeed = 1.5;
  for (const double e : {0.0, 0.7, 1.0}) {
    for (const double beside : {0.05, 0.15}) {
      const double end = 0.18;
      const World start = among({rod(Vec3(-0.2, -end, 0), Vec3(kSpeed, 0, 0)),
                                 turned(rod(Vec3(0, 0, beside)), Vec3::UnitZ())},
                                0, e);
      const World world = after(start, (0.2 - 2 * kRadius) / kSpeed + kStep);
      const double impulse =
          (1 + e) * kSpeed / (2 / kMass + (end * end + beside * beside) / kAcross);
      const Body &a = world.bodies[0], &b = world.bodies[1];
      EXPECT_NEAR(a.velocity.x(), kSpeed - impulse / kMass, 1e-3 * kSpeed);
      EXPECT_NEAR(b.velocity.x(), impulse / kMass, 1e-3 * kSpeed);
      EXPECT_NEAR(end * a.spin.z(), impulse * end * end / kAcross, 1e-3 * kSpeed);
      EXPECT_NEAR(beside * b.spin.y(), -impulse * beside * beside / kAcross, 1e-3 * kSpeed);
      EXPECT_LT((linear_momentum(world) - linear_momentum(start)).norm(), 1e-15 / kStep);
    }
  }
}

// Balls that meet aslant: friction gives mu of the push, or m v/7. The line of centres is off by
// what they move in a step over their distance.
TEST_P(BodiesByGames, FrictionTurnsBalls) {
  constexpr double kSpeed = 2, kRestitution = 0.5;
  for (const double mu : {0.0, 0.1, 0.5}) {
    const double angle = 0.5;  // of the line of centres to the way
    const Vec3 normal(std::cos(angle), std::sin(angle), 0), across(-normal.y(), normal.x(), 0);
    const Vec3 way = Vec3::UnitX();
    const World start = balls_aslant(normal, kSpeed, mu, kRestitution);
    for (const double step : {kStep, kStep / 8}) {
      const World world = after(start, 0.3, step);
      const double push = (1 + kRestitution) * kMass / 2 * kSpeed * normal.dot(way);
      const double slip = kSpeed * across.dot(way);
      const double friction = -std::copysign(std::min(mu * push, kMass * std::abs(slip) / 7), slip);
      const Body &a = world.bodies[0], &b = world.bodies[1];
      const Vec3 given = push * normal - friction * across;  // to the second
      const double slack = (1 + kRestitution) * kSpeed * kSpeed * step / (2 * kRadius);
      EXPECT_LT((b.velocity - given / kMass).norm(), slack) << mu;
      EXPECT_LT((a.velocity - kSpeed * way + given / kMass).norm(), slack) << mu;
      const Vec3 turn = 2.5 / kMass * normal.cross(-given);  // m/s: of the surface
      EXPECT_LT((kRadius * a.spin - turn).norm(), 2.5 * slack) << mu;
      EXPECT_LT((kRadius * b.spin - turn).norm(), 2.5 * slack) << mu;
      EXPECT_LE(energy(world), energy(start));
    }
  }
}

// Above tan 15 degrees friction holds a pile, below it parts.
TEST_P(BodiesByGames, APileStandsOrParts) {
  for (const double mu : {0.2, 0.6}) {
    const World start = pile(mu), world = after(start, 2);
    if (mu < std::tan(std::numbers::pi / 12)) {
      EXPECT_GT(apart(world, start), 0.1);
      continue;
    }
    EXPECT_LT((world.bodies[2].position - start.bodies[2].position).norm(), 2 * kGain);
    for (const Body& body : world.bodies) EXPECT_LT(body.velocity.norm(), kGain / 100);
  }
}

/// Two sticks that meet aslant as they fall.
World flying(double friction) {
  World world = among({rod(Vec3(0, 1, 0), Vec3(0, 0.5, 0)),
                       turned(rod(Vec3(0.5, 1.2, 0.01), Vec3(-2, 0, 0)), Vec3(-0.8, 0.6, 0))},
                      friction, 0.5);
  world.gravity = Vec3(0, -kGravity, 0);
  world.bodies[1].spin = Vec3(0, 0, -1);
  finish(world);
  return world;
}

TEST_P(BodiesByGames, IsOfFirstOrder) {
  for (const double mu : {0.0, 0.3}) {
    const World floor =
        with(turned(rod(Vec3(0, 0.5, 0)), Vec3(0.8, 0.6, 0)), obstacle(plane_shape(), mu, 0.5));
    for (const World& start : {flying(mu), floor}) {
      constexpr double kUntil = 0.35;
      const World freely = with_change(start, [](World& world) {
        world.pairs.clear();
        world.obstacles.clear();
      });
      const World expected = by_direct(start, kUntil);
      EXPECT_GT(apart(expected, by_direct(freely, kUntil)), 0.05);  // they do touch
      // Errors go up and down with where in a step things meet, by as much as they are.
      const double coarse = apart(expected, after(start, kUntil, kStep));
      const double fine = apart(expected, after(start, kUntil, kStep / 16));
      EXPECT_LT(coarse, 0.05) << mu;
      EXPECT_LT(fine, coarse / 8) << mu;
    }
  }
}

/// Two sticks on chains, of which one swings into the other.
World swinging(double friction, double restitution) {
  World world;
  const auto hang = [&](const Vec3& from, const Vec3& along) {
    Connector chain = worlds::chain(7, 0.3, along, 0.05).connectors[0];
    for (Vec3& at : chain.position) at += from;
    for (Hold& hold : chain.holds) hold.to.point += from;
    chain.holds.push_back({6, worlds::on_body(world.bodies.size(), kLength / 2 * Vec3::UnitY())});
    world.connectors.push_back(chain);
    world.bodies.push_back(turned(rod(from + (0.3 + kLength / 2) * along), -along));
  };
  hang(Vec3::Zero(), -Vec3::UnitY());
  hang(Vec3(0.1, 0, 0.01), Vec3(0.8, -0.6, 0));
  world.pairs = {{0, 1, friction, friction, restitution}};
  finish(world);
  return world;
}

// The rigid links of xpbd answer an impact at once, so that its error falls with the step; springs
// yield, and what that makes stays.
TEST_P(BodiesByGames, WhatHangsIsHitWithItsChain) {
  constexpr double kUntil = 0.5;
  for (const double mu : {0.0, 0.3}) {
    for (const double e : {0.0, 0.5}) {
      const World start = swinging(mu, e);
      const World passes = with_change(start, [](World& world) { world.pairs.clear(); });
      const World expected = by_direct(start, kUntil);
      const double change = apart(expected, by_direct(passes, kUntil));
      EXPECT_GT(change, 0.1);  // they do touch
      const World world = after(start, kUntil);
      EXPECT_LE(depth(world), 1e-4);
      const double coarse = apart(expected, world);
      EXPECT_LT(coarse, change / 4) << mu << " " << e;
      if (std::string(GetParam()) == "springs") continue;
      EXPECT_LT(coarse, 0.02) << mu << " " << e;
      EXPECT_LT(apart(expected, after(start, kUntil, kStep / 16)), coarse / 5) << mu << " " << e;
    }
  }
}

TEST_P(BodiesByGames, NothingPassesInAStorm) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const World start = storm(seed);
    Simulation simulation = simulate(start);
    for (int frame = 1; frame <= 90; ++frame) {
      simulation.advance_to(frame / 60.0);
      EXPECT_LE(depth(simulation.world()), 1e-3) << seed;
    }
    EXPECT_LT(energy(simulation.world()), 0.5 * energy(start)) << seed;  // all have landed
  }
}

INSTANTIATE_TEST_SUITE_P(Both, BodiesByGames, testing::Values("xpbd", "springs"));

}  // namespace
}  // namespace taut::body_contacts_test
