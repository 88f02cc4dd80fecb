// Links that touch thin wires between their beads, by the direct method: known answers.
#include <gtest/gtest.h>

#include <array>

#include "link_worlds.h"
#include "sim/measure/measure.h"

namespace taut::link_answers_test {
namespace {

using namespace link_worlds;

/// A link that comes at v gets the impulse (1 + e) v/((1 - s)^2/m + s^2/m), in the shares 1 - s and
/// s for its beads, in frames of any length.
TEST(LinkAnswers, AnImpactActsByItsLevers) {
  for (const double speed : {0.1, 300.0}) {
    for (const double share : {0.02, 0.3, 0.5, 0.9}) {
      for (const double restitution : {0.0, 0.6, 1.0}) {
        for (const double fps : {10.0, 60.0, 1000.0}) {
          Obstacle wire = post(kWire, Vec3::Zero());
          wire.restitution = restitution;
          World world = rod(share, 0, 0.0213, wire);
          world.gravity.setZero();
          for (Vec3& velocity : world.connectors[0].velocity) velocity = Vec3(0, -speed, 0);
          finish(world);
          // Less than a thousandth of a turn later.
          const double until = 0.0213 / speed * 1.001;
          Simulation simulation = by_direct(world);
          for (double time = 0; time < until;) {
            time = std::min(time + 1 / fps, until);
            simulation.advance_to(time);
          }
          const double impulse =
              (1 + restitution) * speed / ((1 - share) * (1 - share) + share * share);
          const Connector& after = simulation.world().connectors[0];
          // By what the rod has turned since, its beads' velocities have, too.
          const double turned = impulse * 0.0213 * 1e-3;
          EXPECT_NEAR(after.velocity[0].y(), (1 - share) * impulse - speed, turned)
              << speed << " " << share << " " << restitution << " " << fps;
          EXPECT_NEAR(after.velocity[1].y(), share * impulse - speed, turned);
          EXPECT_LE(penetration_of_links(simulation.world()), 1e-12);
        }
      }
    }
  }
}

/// A rod that comes at a wire with its middle loses all of its speed, and stays there.
TEST(LinkAnswers, NoRodPassesAWireHoweverFast) {
  for (const double speed : {3.0, 300.0, 3000.0}) {
    for (const double fps : {5.0, 60.0, 997.0}) {
      World world = rod(0.5, 0, 0.3, post(kWire, Vec3::Zero()));
      world.gravity.setZero();
      for (Vec3& velocity : world.connectors[0].velocity) velocity = Vec3(0, -speed, 0);
      finish(world);
      Simulation simulation = by_direct(world);
      for (int frame = 1; frame <= fps / 2; ++frame) simulation.advance_to(frame / fps);
      for (int end : {0, 1}) {
        EXPECT_NEAR(simulation.world().connectors[0].position[end].y(), kWire + kThickness, 1e-9);
        EXPECT_LT(simulation.world().connectors[0].velocity[end].norm(), 1e-9 * speed);
      }
    }
  }
}

/// A rod that slides over a wire without friction. With r the distance of its axis from the wire's,
/// q its angle, s from its centre to where it touches and w = s + r q, Lagrange's equations are
///   w'' = s q'^2 + g sin q,   (s^2 + l^2/4) q'' = g s cos q - r s q'^2 - 2 s s' q'
Vec3 sliding_centre(double angle, double offset, double until) {
  constexpr double r = kWire + kThickness;
  using State = Eigen::Vector4d;  // w, q, w', q'
  const auto rate = [](const State& at) {
    const double s = at[0] - r * at[1], slides = at[2] - r * at[3], spin = at[3];
    const double turns =
        kGravity * s * std::cos(at[1]) - r * s * spin * spin - 2 * s * slides * spin;
    return State(at[2], at[3], s * spin * spin + kGravity * std::sin(at[1]),
                 turns / (s * s + 0.25));
  };
  State at(offset + r * angle, angle, 0, 0);
  constexpr int kSteps = 4000;
  const double h = until / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const State a = rate(at), b = rate(at + h / 2 * a), c = rate(at + h / 2 * b),
                d = rate(at + h * c);
    at += h / 6 * (a + 2 * b + 2 * c + d);
  }
  const Vec3 along(std::cos(at[1]), std::sin(at[1]), 0), normal(-along.y(), along.x(), 0);
  return r * normal - (at[0] - r * at[1]) * along;
}

/// Of second order in place, of third in energy, which the lever of a step's mean share keeps.
TEST(LinkAnswers, ARodSlidesOverAWireInSecondOrder) {
  constexpr double kAngle = 0.2, kOffset = 0.1, kUntil = 0.25;
  const Vec3 expected = sliding_centre(kAngle, kOffset, kUntil);
  std::array<double, 3> error{}, gain{};
  for (std::size_t i = 0; i < error.size(); ++i) {
    const World world = rod(0.5 + kOffset, kAngle, 0, post(kWire, Vec3::Zero()));
    Simulation simulation(world, make_method("direct", {{"step", 1.0 / (480 << i)}}));
    const double before = energy(simulation.world());
    simulation.advance_to(kUntil);
    const Connector& after = simulation.world().connectors[0];
    error[i] = ((after.position[0] + after.position[1]) / 2 - expected).norm();
    gain[i] = std::abs(energy(simulation.world()) - before);
    EXPECT_LE(penetration_of_links(simulation.world()), 1e-12);
  }
  for (std::size_t i = 1; i < error.size(); ++i) {
    EXPECT_NEAR(error[i - 1] / error[i], 4, 0.1);
    EXPECT_NEAR(gain[i - 1] / gain[i], 4, 0.1);
  }
  EXPECT_LT(error.back(), 1e-6);
}

/// On a wire under its middle a rod is in balance at any angle below that of friction; above, it
/// begins to slide by g (sin a - mu cos a) t^2/2.
TEST(LinkAnswers, FrictionHoldsARodUpToItsAngle) {
  constexpr double kFriction = 0.5, kHeld = 0.45, kSlides = 0.6;  // atan 0.5 = 0.4636
  Simulation held = by_direct(rod(0.5, kHeld, 0, post(kWire, Vec3::Zero(), kFriction)));
  const Vec3 before = held.world().connectors[0].position[0];
  held.advance_to(1);
  EXPECT_LT((held.world().connectors[0].position[0] - before).norm(), 1e-9);
  EXPECT_LT(fastest(held.world()), 1e-9);

  constexpr double kUntil = 0.03;
  Simulation slides = by_direct(rod(0.5, kSlides, 0, post(kWire, Vec3::Zero(), kFriction)), 1e-6);
  const Vec3 from = slides.world().connectors[0].position[0];
  slides.advance_to(kUntil);
  const double way =
      kGravity * (std::sin(kSlides) - kFriction * std::cos(kSlides)) * kUntil * kUntil / 2;
  // What it turns by meanwhile is of the fourth order in time.
  EXPECT_NEAR((slides.world().connectors[0].position[0] - from).norm(), way, 2e-3 * way);
}

/// A rope that falls on thin wires of any kind and place.
World rope_on_wires(unsigned seed) {
  Dice dice(seed);
  World world;
  const auto particles = static_cast<std::size_t>(2 + dice.pick(11));
  Connector rope = straight_connector("rope", 1, dice.scale(0.02, 1), particles,
                                      Vec3(dice.between(-0.8, -0.2), 0.6, 0),
                                      (Vec3::UnitX() + dice.within(0.4)).normalized());
  rope.radius = dice.pick(2) == 0 ? dice.scale(1e-4, 0.01) : 0;
  rope.links_touch = true;
  const Vec3 velocity = dice.within(3), spin = dice.within(2);
  const bool held = dice.pick(3) == 0;
  for (std::size_t i = 0; i < particles; ++i) {
    rope.velocity[i] = spin.cross(rope.position[i] - rope.position[0]);
    if (!held) rope.velocity[i] += velocity;
  }
  if (held) rope.holds = {{0, worlds::fixed_at(rope.position[0])}};
  world.connectors = {rope};
  for (int k = 0; k < 5; ++k) {
    const double radius = dice.scale(2e-4, 5e-3);
    const Shape shape = dice.pick(2) == 0 ? capsule_shape(radius, 1.5)
                                          : box_shape(Vec3(radius, 1, radius), 0.1 * radius);
    Obstacle wire = obstacle(shape, dice.between(0, 1));
    wire.place = {Vec3(-0.6 + 0.3 * k, dice.between(0, 0.4), 0),
                  rotation_between(Vec3::UnitY(), (Vec3::UnitZ() + dice.within(0.6)).normalized())};
    world.obstacles.push_back(wire);
  }
  finish(world);
  return world;
}

TEST(LongLinkAnswers, NoRopeGainsEnergyOnWiresOrPassesOne) {
  constexpr double kTolerance = 1e-3;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Simulation simulation = by_direct(rope_on_wires(seed), kTolerance);
    // The weight of all, lifted by the tolerance.
    const double mass = simulation.world().connectors[0].mass;
    const double lifted = mass * kGravity * kTolerance;
    double least = energy(simulation.world());
    for (int frame = 1; frame <= 60; ++frame) {
      simulation.advance_to(frame / 60.0);
      ASSERT_LE(penetration_of_links(simulation.world()), 1e-9) << seed;
      ASSERT_LT(stretch_max(simulation.world()), 1e-6) << seed;
      ASSERT_LE(energy(simulation.world()), least + lifted) << seed << ' ' << frame;
      least = std::min(least, energy(simulation.world()));
    }
  }
}

}  // namespace
}  // namespace taut::link_answers_test
