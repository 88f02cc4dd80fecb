// Ropes and chains at obstacles by the direct method: limits of many links, known beforehand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "contact_worlds.h"
#include "sim/measure/measure.h"

namespace taut::contact_rope_test {
namespace {

using namespace contact_worlds;
using worlds::kGravity;

// The loads at which a polygon of links slips: where the links leave the post they are tangent, and
// every bead turns the chain by half a chord's angle on either side. Beads have weight.
double heaviest(const World& world, std::size_t left, std::size_t arc, std::size_t chords,
                double friction) {
  const Connector& chain = world.connectors[0];
  const double half = std::numbers::pi / static_cast<double>(arc) / 2;
  const double bead = chain.mass / static_cast<double>(chain.particles()) * kGravity;
  double tension = (chain.particle_mass.front() * kGravity) + bead * static_cast<double>(left - 1);
  for (std::size_t k = 0; k <= chords; ++k) {
    const double angle = std::numbers::pi * (1 - static_cast<double>(k) / static_cast<double>(arc));
    // Along the tangent (the way it would slip) and inwards, of what pulls at the bead.
    const double before = k == 0 ? 0 : half, after = k == chords ? 0 : half;
    // Weight: its parts along (sin a, -cos a) and inwards.
    const double along = bead * std::cos(angle), inwards = bead * std::sin(angle);
    // T' cos(after) + along - T cos(before) = mu (T sin(before) + T' sin(after) + inwards)
    tension =
        (tension * (std::cos(before) + friction * std::sin(before)) + friction * inwards - along) /
        (std::cos(after) - friction * std::sin(after));
  }
  return tension;
}

// The polygon's own ratio of loads, which tends to exp(mu angle): a thousandth less and nothing
// moves, a thousandth more and it slips.
TEST(ContactRope, ACapstanHoldsAsMuchAsItMust) {
  constexpr std::size_t arc = 12, left = 2, right = 2;
  constexpr double mass = 1e-3;
  for (const double mu : {0.2, 0.3}) {
    World world = over_post(arc, 0, left, right, 0.01, mass, mu);
    Connector& chain = world.connectors[0];
    chain.particle_mass.front() += 0.5;
    const double bead = mass / static_cast<double>(chain.particles()) * kGravity;
    const double most = heaviest(world, left, arc, arc, mu);
    EXPECT_NEAR(most / (chain.particle_mass.front() * kGravity), std::exp(mu * std::numbers::pi),
                0.02 * std::exp(mu * std::numbers::pi));
    const double own = bead * static_cast<double>(right);
    const double bare = chain.particle_mass.back();
    for (const double more : {-1e-4, 1e-4}) {
      chain.particle_mass.back() = bare + (most * (1 + more) - own) / kGravity;
      finish(world);
      Simulation simulation = by_direct(world);
      simulation.advance_to(0.1);
      const double sunk =
          chain.position.back().y() - simulation.world().connectors[0].position.back().y();
      // Both loads are accelerated by what is too much.
      const double moving = chain.particle_mass.front() + chain.particle_mass.back();
      const double free = more * most / moving * 0.1 * 0.1 / 2;
      if (more < 0) {
        EXPECT_NEAR(sunk, 0, 1e-9) << mu;
      } else {
        EXPECT_GT(sunk, 0.3 * free) << mu;
        EXPECT_LT(sunk, free) << mu;
      }
    }
  }
}

// Six turns and a half: a ratio of 2e5 between the loads, weights of the chain included.
TEST(ContactRope, SixTurnsHoldAsMuchAsTheyMust) {
  constexpr std::size_t arc = 24, turns = 6, left = 2, right = 2;
  constexpr double mu = 0.3, bead = 0.02, time = 0.01;
  constexpr std::size_t chords = (2 * turns + 1) * arc;
  constexpr double mass = bead * (left + chords + right + 1);
  World world = over_post(arc, turns, left, right, 0.02, mass, mu);
  Connector& chain = world.connectors[0];
  chain.particle_mass.front() += 0.5;
  const double most = heaviest(world, left, arc, chords, mu);
  const double bare = chain.particle_mass.back();
  for (const double more : {-1e-2, 1e-2}) {
    chain.particle_mass.back() = bare + most * (1 + more) / kGravity - bead * right;
    finish(world);
    Simulation simulation = by_direct(world);
    simulation.advance_to(time);
    const double sunk =
        chain.position.back().y() - simulation.world().connectors[0].position.back().y();
    const double free = more * most / chain.particle_mass.back() * time * time / 2;
    if (more < 0) {
      EXPECT_NEAR(sunk, 0, 1e-4 * -free);
    } else {
      EXPECT_GT(sunk, 0.3 * free);
      EXPECT_LT(sunk, free);
    }
  }
}

// x'' = 2 g x / L without friction, whatever the post's radius: the error falls with the links.
TEST(ContactRope, AChainSlidesOffAPeg) {
  double error[3];
  for (const std::size_t fine : {1, 2, 4}) {
    const std::size_t each = 40 * fine;
    const double link = 0.01 / static_cast<double>(fine);
    const World world = over_post(8 * fine, 0, each - 2 * fine, each + 2 * fine, link, 1, 0);
    Simulation simulation = by_direct(world, 1e-5);
    simulation.advance_to(0.4);
    const double rate = std::sqrt(2 * kGravity / world.connectors[0].length);
    const double x = 0.02 * std::cosh(rate * 0.4);
    const double hangs = -simulation.world().connectors[0].position.back().y();
    error[fine / 2] = std::abs(hangs - link * static_cast<double>(each) - x);
    EXPECT_LE(penetration(simulation.world()), 1e-9);
  }
  EXPECT_LT(error[0], 2e-3);
  EXPECT_LT(error[1], 0.6 * error[0]);
  EXPECT_LT(error[2], 0.6 * error[1]);
}

// A weight on a string winds it up on a post: it keeps its speed, and the free length is
// sqrt(L^2 - 2 R v t); of second order in the links.
TEST(ContactRope, AStringWindsUpOnAPost) {
  constexpr double radius = 0.05, time = 3;
  double error[3];
  for (const std::size_t fine : {1, 2, 4}) {
    const std::size_t links = 20 * fine;
    World world;
    world.gravity.setZero();
    Connector string =
        straight_connector("string", 1, 1e-3, links + 1, Vec3(0, radius, 0), Vec3::UnitX());
    string.particle_mass.back() += 1;
    string.holds = {{0, worlds::fixed_at(Vec3(0, radius, 0))}};
    for (std::size_t i = 0; i <= links; ++i) {
      string.velocity[i].y() = -static_cast<double>(i) / static_cast<double>(links);
    }
    world.connectors = {string};
    world.obstacles = {post(radius, Vec3::Zero())};
    finish(world);
    Simulation simulation = by_direct(world, 1e-4);
    simulation.advance_to(time);
    const Vec3 at = simulation.world().connectors[0].position.back();
    const double free = std::sqrt(at.squaredNorm() - radius * radius);
    error[fine / 2] = std::abs(free - std::sqrt(1 - 2 * radius * time));
    EXPECT_NEAR(kinetic_energy(simulation.world()), kinetic_energy(world), 1e-4 * 0.5);
  }
  EXPECT_LT(error[0], 0.01);
  EXPECT_LT(error[1], 0.35 * error[0]);
  EXPECT_LT(error[2], 0.35 * error[1]);
}

// The tolerance holds for a rope that swings against a post, up to where motions part.
TEST(ContactRope, ErrorsFollowTheTolerance) {
  World world = worlds::chain(31, 1, Vec3::UnitX(), 0.1);
  world.connectors[0].radius = 0.005;
  world.obstacles = {post(0.05, Vec3(0.1, -0.3, 0), 0.3)};
  world.topology = structure(world);
  const auto after = [&](double tolerance) {
    Simulation simulation = by_direct(world, tolerance);
    simulation.advance_to(0.65);
    return simulation.world().connectors[0].position;
  };
  const auto apart = [](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(a.size()));
  };
  const auto best = after(1e-6);
  for (const double tolerance : {1e-3, 1e-4, 1e-5}) {
    EXPECT_LT(apart(after(tolerance), best), tolerance) << tolerance;
  }
}

// A stick at a rope's end over a floor: bodies do not collide, the rope's beads do.
TEST(ContactRope, ABodyAtTheEnd) {
  World world = worlds::chain_with_box(9);
  Obstacle floor = obstacle(plane_shape(), 0.4);
  floor.place.position.y() = -0.25;
  world.obstacles = {floor};
  world.topology = structure(world);
  for (Vec3& at : world.connectors[0].position) ASSERT_GT(at.y(), -0.25);
  Simulation simulation = by_direct(world);
  for (int frame = 1; frame <= 120; ++frame) {
    simulation.advance_to(frame / 60.0);
    EXPECT_LE(penetration(simulation.world()), 1e-9);
    EXPECT_LT(stretch_max(simulation.world()), 1e-7);
  }
  EXPECT_LT(kinetic_energy(simulation.world()), 2.0);
}

}  // namespace
}  // namespace taut::contact_rope_test
