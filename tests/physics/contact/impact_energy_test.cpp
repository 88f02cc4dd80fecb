// Impacts with friction and restitution make no energy: Kane's paradox and what is done about it,
// by the direct method and by the truth alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "contact_sticks.h"
#include "sim/measure/measure.h"
#include "tests/support/dice.h"

namespace taut::impact_energy_test {
namespace {

using namespace contact_sticks;

class ImpactEnergy : public testing::TestWithParam<const char*> {
 protected:
  bool is_truth() const { return std::string(GetParam()) == "truth"; }
  Simulation simulate(const World& world, double step) const {
    return {world, make_method(GetParam(), is_truth() ? Settings{} : Settings{{"step", step}})};
  }
};

/// Two beads on a link along `d` that fall with v on a floor which the first sticks to: it is
/// thrown back with e |v_y|, and the link's impulse makes d.v of both the same. What that makes is
/// |u|^2 (1 + d_y^2) + |v|^2 - (d.v)^2 over the mass, and no more than 2 |v|^2.
TEST_P(ImpactEnergy, ALinkStruckAslantIsThrownBackWithAllThatThereIs) {
  const Vec3 v(0.2, -1, 0), d(std::cos(0.8), std::sin(0.8), 0);
  const double most =
      std::sqrt((v.squaredNorm() + d.dot(v) * d.dot(v)) / (1 + d.y() * d.y())) / -v.y();
  ASSERT_LT(most, 0.96);
  for (const double e : {0.0, 0.5, 0.9, 0.96, 1.0}) {
    World world;
    world.gravity.setZero();
    constexpr double kArrives = 0.11;  // s
    Connector rod = straight_connector("rod", 0.5, 0.2, 2, -kArrives * v, d);
    for (Vec3& moves : rod.velocity) moves = v;
    world.connectors = {rod};
    world.obstacles = {obstacle(plane_shape(), 0.5, e)};
    finish(world);
    Simulation simulation = simulate(world, 1e-3);
    simulation.advance_to(kArrives + 1e-6);
    const Vec3 thrown(0, -std::min(e, most) * v.y(), 0), other = v + d * d.dot(thrown - v);
    const auto& velocity = simulation.world().connectors[0].velocity;
    // Within a microsecond the link turns by as much.
    EXPECT_LT((velocity[0] - thrown).norm(), 1e-5) << e;
    EXPECT_LT((velocity[1] - other).norm(), 1e-5) << e;
    EXPECT_LE(kinetic_energy(simulation.world()), (1 + 1e-10) * kinetic_energy(world)) << e;
  }
}

/// A rope of a few beads that is thrown on a floor and, if so, posts.
World thrown_rope(unsigned seed, bool posts) {
  Dice dice(seed);
  World world;
  const auto particles = static_cast<std::size_t>(2 + dice.pick(7));
  Connector rope = straight_connector("rope", 1, dice.scale(0.02, 1), particles,
                                      Vec3(dice.between(-0.8, -0.2), dice.between(0.5, 1), 0),
                                      (Vec3::UnitX() + dice.within(0.4)).normalized());
  rope.radius = dice.between(0, 0.01);
  const Vec3 velocity = dice.within(3), spin = dice.within(4);
  for (std::size_t i = 0; i < particles; ++i) {
    rope.velocity[i] = velocity + spin.cross(rope.position[i] - rope.position[0]);
  }
  world.connectors = {rope};
  world.obstacles = {obstacle(plane_shape(), dice.between(0, 2), dice.between(0, 1))};
  for (int k = 0; posts && k < 4; ++k) {
    Obstacle made = post(dice.scale(0.03, 0.15), Vec3(-0.6 + 0.4 * k, dice.between(0.1, 0.4), 0),
                         dice.between(0, 2));
    made.restitution = dice.between(0, 1);
    world.obstacles.push_back(made);
  }
  finish(world);
  return world;
}

/// The most that it gains above what it had before, over the energy's scale.
double most_gained(Simulation simulation, double until) {
  const double scale = energy_scale(simulation.world());
  double least = energy(simulation.world()), most = 0;
  for (int frame = 1; frame <= 60 * until; ++frame) {
    simulation.advance_to(frame / 60.0);
    most = std::max(most, (energy(simulation.world()) - least) / scale);
    least = std::min(least, energy(simulation.world()));
  }
  return most;
}

// Newton's law would make up to a tenth of the scale in these worlds. Steps keep energy in second
// order.
TEST_P(ImpactEnergy, NoRopeGainsAny) {
  const unsigned seeds = is_truth() ? 30 : 150;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    for (const bool posts : {false, true}) {
      const World world = thrown_rope(seed, posts);
      // It knows no bead that touches two obstacles at once.
      if ((is_truth() && posts) || penetration(world) > 0) continue;
      EXPECT_LE(most_gained(simulate(world, 2e-3), is_truth() ? 0.5 : 1), is_truth() ? 1e-9 : 1e-3)
          << seed << (posts ? " with posts" : "");
    }
  }
}

/// A thin rod that is thrown on a floor.
World thrown_rod(unsigned seed) {
  Dice dice(seed);
  Body body = turned(rod(Vec3(0, 0.4, 0), dice.within(2)), dice.direction());
  const Vec3 axis = body.rotation * Vec3::UnitY(), spin = dice.within(8);
  body.spin = spin - spin.dot(axis) * axis;
  return with(body, obstacle(plane_shape(), dice.between(0, 2), dice.between(0, 1)));
}

// A body's steps keep energy in second order; Newton's law would make up to half of the scale.
TEST_P(ImpactEnergy, NoRodGainsAny) {
  double most[2] = {};
  constexpr double kSteps[] = {4e-3, 1e-3};
  for (unsigned seed = 31; seed <= 60; ++seed) {
    const World world = thrown_rod(seed);
    for (int i = 0; i < (is_truth() ? 1 : 2); ++i) {
      most[i] = std::max(most[i], most_gained(simulate(world, kSteps[i]), 0.6));
    }
  }
  EXPECT_LE(most[0], is_truth() ? 1e-9 : 1e-5);
  if (is_truth()) return;
  EXPECT_LE(most[1], most[0] / 8) << "of second order";
}

INSTANTIATE_TEST_SUITE_P(Both, ImpactEnergy, testing::Values("direct", "truth"));

// In worlds where Newton's law would gain energy.
TEST(ImpactEnergies, TwoSolversAgree) {
  for (const unsigned seed : {29u, 71u, 109u}) {
    const World world = thrown_rope(seed, false);
    Simulation truth(world, make_method("truth", {}));
    truth.advance_to(0.5);
    double before = 0;
    for (const double step : {1e-3, 5e-4, 2.5e-4}) {
      Simulation other(world, make_method("direct", {{"step", step}}));
      other.advance_to(0.5);
      double error = 0;
      for (std::size_t i = 0; i < world.connectors[0].particles(); ++i) {
        const Vec3 apart =
            truth.world().connectors[0].position[i] - other.world().connectors[0].position[i];
        error = std::max(error, apart.norm());
      }
      if (before > 0) {
        EXPECT_LT(error, std::max(0.4 * before, 5e-6)) << seed << ' ' << step;
      }
      before = error;
    }
    EXPECT_LT(before, 1e-5) << seed;
  }
}

}  // namespace
}  // namespace taut::impact_energy_test
