// Free bodies that touch each other, by the direct method and by the truth: motions that are known
// beforehand.
#include <gtest/gtest.h>

#include "contact_sticks.h"
#include "sim/measure/measure.h"

namespace taut::body_pair_test {
namespace {

using namespace contact_sticks;

class BodyPairs : public testing::TestWithParam<const char*> {
 protected:
  bool is_truth() const { return std::string(GetParam()) == "truth"; }
  Simulation simulate(const World& world, double tolerance = 1e-4) const {
    const Settings settings = is_truth() ? Settings{} : Settings{{"tolerance", tolerance}};
    return {world, make_method(GetParam(), settings)};
  }
};

// End to end, and side by side: momentum stays, and they part as fast as e says.
TEST_P(BodyPairs, EqualOnesHeadOn) {
  constexpr double kSpeed = 2;
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const Vec3& way : {Vec3(Vec3::UnitY()), Vec3(Vec3::UnitX())}) {
      const Vec3 apart = (kLength + 0.1) * way;
      const World world = among({rod(-apart, kSpeed * way), rod(apart)}, 0.4, e);
      Simulation simulation = simulate(world);
      simulation.advance_to(0.6);
      const Body &a = simulation.world().bodies[0], &b = simulation.world().bodies[1];
      EXPECT_LT((linear_momentum(simulation.world()) - linear_momentum(world)).norm(), 1e-15);
      EXPECT_NEAR((b.velocity - a.velocity).dot(way), e * kSpeed, 1e-13) << e;
      EXPECT_LT(a.spin.norm() + b.spin.norm(), 1e-10);
      EXPECT_LE(depth(simulation.world()), 1e-9 * kLength);
    }
  }
}

// J = (1 + e) v/(1/m + 1/m + l^2/I + d^2/I): an end of one at a distance d from the other's middle.
TEST_P(BodyPairs, AnEndHitsBesideTheMiddle) {
  constexpr double kSpeed = 1.5;
  for (const double e : {0.0, 0.7, 1.0}) {
    for (const double beside : {0.05, 0.15}) {
      // Two rods, one along y and the other along z, cross near the end of the first.
      const double end = 0.18;
      const World world = among({rod(Vec3(-0.2, -end, 0), Vec3(kSpeed, 0, 0)),
                                 turned(rod(Vec3(0, 0, beside)), Vec3::UnitZ())},
                                0, e);
      Simulation simulation = simulate(world);
      simulation.advance_to((0.2 - 2 * kRadius) / kSpeed + 1e-9);
      const double inverse_mass = 2 / kMass + (end * end + beside * beside) / kAcross;
      const double impulse = (1 + e) * kSpeed / inverse_mass;
      const Body &a = simulation.world().bodies[0], &b = simulation.world().bodies[1];
      EXPECT_NEAR(a.velocity.x(), kSpeed - impulse / kMass, 1e-8);
      EXPECT_NEAR(b.velocity.x(), impulse / kMass, 1e-8);
      EXPECT_NEAR(a.spin.z(), impulse * end / kAcross, 1e-6);
      EXPECT_NEAR(b.spin.y(), -impulse * beside / kAcross, 1e-6);
      const double before = energy(world),
                   lost = (1 - e * e) * kSpeed * kSpeed / (2 * inverse_mass);
      EXPECT_NEAR(energy(simulation.world()), before - lost, 1e-8);
      EXPECT_LT((linear_momentum(simulation.world()) - linear_momentum(world)).norm(), 1e-14);
      EXPECT_LT((angular_momentum(simulation.world()) - angular_momentum(world)).norm(), 1e-9);
    }
  }
}

// Balls that meet aslant: friction gives mu of the push, or what stops the slip, m v/7 between
// solid balls; both turn the same way.
TEST_P(BodyPairs, FrictionTurnsBalls) {
  constexpr double kSpeed = 2, kRestitution = 0.5;
  for (const double mu : {0.0, 0.1, 0.5}) {
    const double angle = 0.5;  // of the line of centres to the way
    const Vec3 normal(std::cos(angle), std::sin(angle), 0), across(-normal.y(), normal.x(), 0);
    const Vec3 way = Vec3::UnitX();
    const World world = balls_aslant(normal, kSpeed, mu, kRestitution);
    Simulation simulation = simulate(world);
    simulation.advance_to(0.3);
    const double push = (1 + kRestitution) * kMass / 2 * kSpeed * normal.dot(way);
    const double slip = kSpeed * across.dot(way);
    const double friction = -std::copysign(std::min(mu * push, kMass * std::abs(slip) / 7), slip);
    const Body &a = simulation.world().bodies[0], &b = simulation.world().bodies[1];
    const Vec3 given = push * normal - friction * across;  // to the second
    // Where they touch is known to the nanometre that is located, of a radius of a centimetre.
    EXPECT_LT((b.velocity - given / kMass).norm(), 1e-6) << mu;
    EXPECT_LT((a.velocity - kSpeed * way + given / kMass).norm(), 1e-6) << mu;
    const double inertia = 0.4 * kMass * kRadius * kRadius;
    const Vec3 spin = kRadius / inertia * normal.cross(-given);
    EXPECT_LT((a.spin - spin).norm(), 1e-4) << mu;
    EXPECT_LT((b.spin - spin).norm(), 1e-4) << mu;
    EXPECT_LT((angular_momentum(simulation.world()) - angular_momentum(world)).norm(), 1e-9);
    EXPECT_LE(energy(simulation.world()), energy(world));
  }
}

// In a row that touches, all impacts are one: -v/3, 2 v/3, 2 v/3 for e = 1. With gaps they follow
// each other, and the last takes all.
TEST_P(BodyPairs, ThreeInARow) {
  constexpr double kSpeed = 1;
  for (const double gap : {0.0, 0.01}) {
    const double next = 2 * kRadius + gap;
    const World world =
        among({ball(Vec3(-0.1, 0, 0), Vec3(kSpeed, 0, 0)), ball(Vec3::Zero(), Vec3::Zero()),
               ball(Vec3(next, 0, 0), Vec3::Zero())},
              0, 1);
    Simulation simulation = simulate(world);
    simulation.advance_to(0.2);
    const std::vector<Body>& bodies = simulation.world().bodies;
    const Vec3 expected = gap > 0 ? Vec3(0, 0, 1) : Vec3(-1, 2, 2) / 3;
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(bodies[static_cast<std::size_t>(i)].velocity.x(), kSpeed * expected[i], 1e-13);
    }
  }
}

// With a coefficient above tan 15 degrees it stands.
TEST_P(BodyPairs, APileStaysAtRest) {
  const World world = pile(0.3);
  Simulation simulation = simulate(world);
  simulation.advance_to(is_truth() ? 0.3 : 2);
  for (std::size_t b = 0; b < 3; ++b) {
    const Body& body = simulation.world().bodies[b];
    EXPECT_LT((body.position - world.bodies[b].position).norm(), 1e-9) << b;
    EXPECT_LT(body.velocity.norm(), 1e-9) << b;
    EXPECT_LT(body.spin.norm(), 1e-7) << b;
  }
}

// Without friction the upper one parts the others, and energy gives their speeds by the angle a of
// the line of centres: r a'^2 (1 + cos^2 a) = g (cos 30 - cos a).
TEST_P(BodyPairs, ASmoothPileParts) {
  Simulation simulation = simulate(pile(0), 1e-6);
  for (int frame = 1; frame <= 10; ++frame) {
    simulation.advance_to(frame / 240.0);
    const std::vector<Body>& bodies = simulation.world().bodies;
    const double cosine = (bodies[2].position.y() - kRadius) / (2 * kRadius);
    EXPECT_LE(depth(simulation.world()), 1e-9 * kLength);
    if (cosine < 0.6) break;  // they part at 58 degrees
    const double turns =
        std::sqrt(kGravity * (std::sqrt(0.75) - cosine) / (kRadius * (1 + cosine * cosine)));
    const double slack = is_truth() ? 1e-7 : 1e-2;
    EXPECT_NEAR(bodies[1].velocity.x(), 2 * kRadius * cosine * turns, slack * kRadius * turns)
        << frame;
    EXPECT_NEAR(bodies[0].velocity.x(), -bodies[1].velocity.x(), 1e-9) << frame;
  }
}

// A stick that lies across two others on the floor.
TEST_P(BodyPairs, AStickOnTwoOthersStaysAtRest) {
  World world = among({turned(rod(Vec3(-0.1, kRadius, 0)), Vec3::UnitZ()),
                       turned(rod(Vec3(0.1, kRadius, 0)), Vec3::UnitZ()),
                       turned(rod(Vec3(0.02, 3 * kRadius, 0.03)), Vec3::UnitX())},
                      0.3);
  world.gravity = Vec3(0, -kGravity, 0);
  world.obstacles = {obstacle(plane_shape(), 0.3)};
  finish(world);
  Simulation simulation = simulate(world);
  simulation.advance_to(is_truth() ? 0.3 : 2);
  for (std::size_t b = 0; b < 3; ++b) {
    const Body& body = simulation.world().bodies[b];
    EXPECT_LT((body.position - world.bodies[b].position).norm(), 1e-9) << b;
    EXPECT_LT(body.velocity.norm(), 1e-9) << b;
  }
}

/// Two sticks on chains, of which one swings into the other.
World swinging(double friction, double restitution) {
  World world;
  const auto hang = [&](const Vec3& from, const Vec3& along) {
    const std::size_t body = world.bodies.size();
    Connector chain = worlds::chain(5, 0.4, along, 0.05).connectors[0];
    for (Vec3& at : chain.position) at += from;
    for (Hold& hold : chain.holds) hold.to.point += from;
    chain.holds.push_back({4, worlds::on_body(body, kLength / 2 * Vec3::UnitY())});
    world.connectors.push_back(chain);
    world.bodies.push_back(turned(rod(from + (0.4 + kLength / 2) * along), -along));
  };
  hang(Vec3(0, 0, 0), -Vec3::UnitY());
  hang(Vec3(0.15, 0, 0.01), Vec3(0.8, -0.6, 0));
  world.pairs = {{0, 1, friction, friction, restitution}};
  finish(world);
  return world;
}

TEST(BodyPairsOnChains, TwoSolversAgree) {
  for (const double friction : {0.0, 0.3}) {
    const World world = swinging(friction, 0.4);
    Simulation truth(world, make_method("truth", {}));
    constexpr double kUntil = 0.5;
    truth.advance_to(kUntil);
    EXPECT_LE(depth(truth.world()), 1e-11);
    World alone = world;
    alone.pairs.clear();
    finish(alone);
    Simulation passes(alone, make_method("truth", {}));
    passes.advance_to(kUntil);
    const auto apart = [](const World& a, const World& b) {
      double sum = 0;
      for (std::size_t i = 0; i < a.bodies.size(); ++i) {
        sum += (a.bodies[i].position - b.bodies[i].position).norm() +
               kLength / 2 * a.bodies[i].rotation.angularDistance(b.bodies[i].rotation);
      }
      return sum;
    };
    EXPECT_GT(apart(truth.world(), passes.world()), 0.05);  // they do touch
    double before = 0;
    for (const double step : {4e-4, 2e-4, 1e-4}) {
      Simulation other(world, make_method("direct", {{"step", step}}));
      other.advance_to(kUntil);
      EXPECT_LE(depth(other.world()), 1e-9 * kLength);
      const double error = apart(truth.world(), other.world());
      if (before > 0) {
        EXPECT_LT(error, 0.7 * before) << friction;
      }
      before = error;
    }
    EXPECT_LT(before, 1e-4) << friction;
    for (const double tolerance : {1e-3, 1e-4, 1e-5}) {
      Simulation other(world, make_method("direct", {{"tolerance", tolerance}}));
      other.advance_to(kUntil);
      EXPECT_LT(apart(truth.world(), other.world()), 2 * tolerance) << friction;
    }
  }
}

TEST(BodyPairStorms, NothingPassesAndAllLand) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const World world = storm(seed);
    Simulation simulation(world, make_method("direct", {{"tolerance", 1e-3}}));
    for (int frame = 1; frame <= 90; ++frame) {
      simulation.advance_to(frame / 60.0);
      EXPECT_LE(depth(simulation.world()), 1e-9) << seed;
    }
    EXPECT_LT(energy(simulation.world()), 0.5 * energy(world)) << seed;  // all have landed
  }
}

// Bodies that are no pair pass, as if the other were not there.
TEST_P(BodyPairs, OthersPassThrough) {
  World world =
      among({rod(Vec3(-0.3, 0, 0), Vec3(2, 0, 0)), rod(Vec3::Zero()), rod(Vec3(0, 1, 0))});
  world.pairs.erase(world.pairs.begin());  // the first and the second
  finish(world);
  Simulation simulation = simulate(world);
  simulation.advance_to(0.5);
  EXPECT_NEAR(simulation.world().bodies[0].position.x(), 0.7, 1e-12);
  EXPECT_LT(simulation.world().bodies[1].position.norm(), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Both, BodyPairs, testing::Values("direct", "truth"));

}  // namespace
}  // namespace taut::body_pair_test
