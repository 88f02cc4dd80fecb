// Beads that touch free bodies, by the direct method.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "contact_sticks.h"
#include "sim/contact/capsule.h"
#include "sim/measure/measure.h"
#include "sim/world/places.h"
#include "tests/support/dice.h"

namespace taut::bead_body_test {
namespace {

using namespace contact_sticks;

constexpr double kBead = 0.05;    // kg
constexpr double kThick = 0.004;  // m, radius of beads

void touch(World& world, double friction = 0, double restitution = 0) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (std::size_t b = 0; b < world.bodies.size(); ++b) {
      world.bead_pairs.push_back({c, b, friction, friction, restitution});
    }
  }
}

/// The deepest that a bead which nothing holds is in a body that it may touch, m.
double penetration_of_bodies(const World& world) {
  double deepest = 0;
  for (const BeadPair& pair : world.bead_pairs) {
    const Body& body = world.bodies[pair.body];
    const Connector& connector = world.connectors[pair.connector];
    const contact::Capsule solid{body.point(body.capsule.from), body.point(body.capsule.to),
                                 body.capsule.radius};
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (holds(connector, i)) continue;
      const Vec3& at = connector.position[i];
      deepest = std::max(deepest, -contact::least_gap(solid, {at, at, connector.radius}));
    }
  }
  return deepest;
}

/// Two beads, a link along z between them, of which the first meets a rod along y at rest at the
/// height `off` of its centre, with `velocity`, after 0.1 s.
World bead_meets_rod(double off, const Vec3& velocity, double friction, double e) {
  World world;
  world.gravity.setZero();
  const Vec3 at = Vec3(kRadius + kThick, off, 0) - 0.1 * velocity;
  Connector link = straight_connector("link", 0.3, 2 * kBead, 2, at, Vec3::UnitZ());
  link.radius = kThick;
  for (Vec3& v : link.velocity) v = velocity;
  world.connectors = {link};
  world.bodies = {rod(Vec3::Zero())};
  touch(world, friction, e);
  finish(world);
  return world;
}

// Its link lies across and gives nothing: J = (1 + e) v/(1/m + 1/M + a^2/I).
TEST(BeadsAtBodies, ABeadHitsARodBesideItsCentre) {
  constexpr double kSpeed = 2;
  for (const double off : {0.0, 0.1, -0.15}) {
    for (const double e : {0.0, 0.5, 1.0}) {
      const World start = bead_meets_rod(off, -kSpeed * Vec3::UnitX(), 0, e);
      Simulation simulation(start, make_method("direct", {{"step", 1e-3}}));
      simulation.advance_to(0.1 + 1e-6);
      const World& world = simulation.world();
      const double impulse = (1 + e) * kSpeed / (1 / kBead + 1 / kMass + off * off / kAcross);
      // In the next microsecond all turns by as much.
      const double most = 1e-5 * impulse;
      EXPECT_NEAR(world.bodies[0].velocity.x(), -impulse / kMass, most / kMass) << off << e;
      EXPECT_NEAR(world.bodies[0].spin.z(), off * impulse / kAcross, most / kAcross) << off << e;
      EXPECT_NEAR(world.connectors[0].velocity[0].x(), impulse / kBead - kSpeed, most / kBead);
      EXPECT_NEAR(world.connectors[0].velocity[1].x(), -kSpeed, most / kBead) << off << e;
      EXPECT_LE(penetration_of_bodies(world), 1e-9);
    }
  }
}

// Coulomb: mu times the push across it, as long as it slides. A bead does not turn, the rod does.
TEST(BeadsAtBodies, FrictionOfAGrazingBead) {
  constexpr double kMu = 0.3;
  const World start = bead_meets_rod(0, Vec3(-1, 0, 2), kMu, 0);
  Simulation simulation(start, make_method("direct", {{"step", 1e-3}}));
  simulation.advance_to(0.1 + 1e-6);
  const Body& body = simulation.world().bodies[0];
  const double push = 1 / (1 / kBead + 1 / kMass);
  EXPECT_NEAR(body.velocity.x(), -push / kMass, 1e-5 * push / kMass);
  EXPECT_NEAR(body.velocity.z(), kMu * push / kMass, 1e-5 * push / kMass);
  EXPECT_NEAR(body.spin.y(), -kMu * push * kRadius / kAlong, 1e-3 * push * kRadius / kAlong);
}

// A row of rods that is struck on its end by a ball answers as one, as links are rigid.
TEST(BeadsAtBodies, AnImpactIsFeltByTheWholeRow) {
  constexpr std::size_t kBeads = 5;
  World world;
  world.gravity.setZero();
  Connector row = straight_connector("row", 0.4, 0.2, kBeads, Vec3::Zero(), Vec3::UnitX());
  row.radius = kThick;
  world.connectors = {row};
  world.bodies = {ball(Vec3(-0.1 - kRadius - kThick, 0, 0), Vec3::UnitX())};
  touch(world, 0, 0.5);
  finish(world);
  Simulation simulation(world, make_method("direct", {{"step", 1e-3}}));
  simulation.advance_to(0.1 + 1e-6);
  const double impulse = 1.5 / (1 / 0.2 + 1 / kMass);
  for (const Vec3& velocity : simulation.world().connectors[0].velocity) {
    EXPECT_NEAR(velocity.x(), impulse / 0.2, 1e-9);
  }
  EXPECT_NEAR(simulation.world().bodies[0].velocity.x(), 1 - impulse / kMass, 1e-9);
}

/// A rope that lies across a stick, both at rest, which falls with it: one of its ends is held.
World rope_on_stick() {
  World world;
  Body body = turned(rod(Vec3::Zero()), Vec3(0.2, 0.1, 1).normalized());
  const Vec3 axis = body.rotation * Vec3::UnitY(), along(1, 0, 0);
  const Vec3 normal = axis.cross(along).normalized();
  Connector rope =
      straight_connector("rope", 0.5, 0.2, 6, (kRadius + kThick) * normal - 0.2 * along, along);
  rope.radius = kThick;
  rope.holds = {{0, worlds::fixed_at(rope.position[0])}};
  Connector sling = straight_connector(
      "sling", 0.3, 0.05, 4, body.position - kLength / 2 * axis + Vec3(0, 0.3, 0), -Vec3::UnitY());
  sling.holds = {{0, worlds::fixed_at(sling.position[0])},
                 {3, worlds::on_body(0, -kLength / 2 * Vec3::UnitY())}};
  world.bodies = {body};
  world.connectors = {rope, sling};
  world.bead_pairs = {{0, 0, 0, 0, 0}};
  finish(world);
  return world;
}

// The stick swings under the rope, which slides on it. By `xpbd`, whose beads respond by
// themselves, what lasts comes to the same, in first order.
TEST(BeadsAtBodies, ShorterStepsConvergeInSecondOrder) {
  const World start = rope_on_stick();
  const auto after = [&](const char* method, double step) {
    Simulation simulation(start, make_method(method, {{"step", step}}));
    simulation.advance_to(0.2);
    EXPECT_LE(penetration_of_bodies(simulation.world()), 1e-9);
    return simulation.world();
  };
  const World exact = after("direct", 1e-4);
  const auto error = [&](const World& world) {
    return std::max((world.bodies[0].position - exact.bodies[0].position).norm(),
                    (world.connectors[0].position[5] - exact.connectors[0].position[5]).norm());
  };
  double before = 0, before_of_games = 0, gained_before = 0;
  for (const double step : {4e-3, 2e-3, 1e-3}) {
    const World world = after("direct", step);
    const double own = error(world), of_games = error(after("xpbd", step / 8));
    const double gained = std::abs(energy(world) - energy(start));
    EXPECT_LT(own, 1e-5);
    EXPECT_LT(of_games, 5e-4);
    if (before > 0) {
      EXPECT_LT(own, before / 3) << step;
      EXPECT_LT(gained, gained_before / 3) << step;
      EXPECT_LT(of_games, before_of_games / 1.8) << step;
    }
    before = own;
    gained_before = gained;
    before_of_games = of_games;
  }
}

/// Smooth balls that fly at ropes.
World ropes_and_balls(unsigned seed, double restitution) {
  Dice dice(seed);
  World world;
  world.gravity = dice.pick(2) == 0 ? Vec3(Vec3::Zero()) : Vec3(0, -kGravity, 0);
  for (int k = 0; k < 2; ++k) {
    Connector rope = straight_connector("rope" + std::to_string(k), 0.5, dice.scale(0.01, 0.5),
                                        static_cast<std::size_t>(2 + dice.pick(10)),
                                        Vec3(-0.25, 0.1 * k, 0), Vec3::UnitX() + dice.within(0.2));
    rope.radius = dice.between(0, 0.01);
    if (dice.pick(2) == 0) rope.holds = {{0, worlds::fixed_at(rope.position[0])}};
    world.connectors.push_back(rope);
  }
  for (int k = 0; k < 3; ++k) {
    Body body = ball(Vec3(0.15 * k - 0.15, 0.35, 0) + dice.within(0.05),
                     Vec3(0, -dice.between(0.5, 3), 0) + dice.within(0.5));
    body.mass_properties = solid_sphere(dice.scale(0.05, 1), 0.06);
    body.capsule.radius = 0.03;
    body.spin = dice.within(20);
    world.bodies.push_back(body);
  }
  touch(world, 0, restitution);
  finish(world);
  return world;
}

// Steps keep energy in second order.
TEST(BeadsAtBodies, NoRopeGainsAnyFromBalls) {
  for (const double restitution : {0.0, 0.7, 1.0}) {
    for (unsigned seed = 1; seed <= 16; ++seed) {
      const World world = ropes_and_balls(seed, restitution);
      Simulation simulation(world, make_method("direct", {{"step", 2e-3}}));
      const double scale = energy_scale(world);
      double least = energy(world);
      for (int frame = 1; frame <= 60; ++frame) {
        simulation.advance_to(frame / 120.0);
        const World& now = simulation.world();
        ASSERT_LE(energy(now), least + 1e-3 * scale) << seed << ' ' << restitution << ' ' << frame;
        ASSERT_LE(penetration_of_bodies(now), 1e-9) << seed << ' ' << frame;
        least = std::min(least, energy(now));
      }
    }
  }
}

struct Kind {
  double friction = 0, restitution = 0;
  bool gravity = false, obstacles = false, strings = false, bodies_touch = false;
};

/// A nunchaku whose sticks fold about its chain, a rope and a stick that come at each other.
World storm(unsigned seed, const Kind& kind) {
  Dice dice(seed);
  World world;
  if (!kind.gravity) world.gravity.setZero();
  const double thick = dice.scale(1e-3, 0.006);
  const auto stick = [&](const Vec3& end, const Vec3& along) {
    Body body = turned(rod(end + kLength / 2 * along), along);
    body.name += std::to_string(world.bodies.size());
    world.bodies.push_back(body);
  };
  // The nunchaku: its chain along x, its sticks from both ends of that.
  const auto particles = static_cast<std::size_t>(3 + dice.pick(12));
  const double length = dice.between(0.1, 0.4);
  const Vec3 height(0, 1, 0), spin = dice.within(6), velocity = dice.within(1);
  Connector chain =
      straight_connector("chain", length, dice.scale(0.005, 0.1), particles, height, Vec3::UnitX());
  stick(chain.position.front(), -(Vec3::UnitX() + dice.within(0.7)).normalized());
  stick(chain.position.back(), (Vec3::UnitX() + dice.within(0.7)).normalized());
  chain.holds = {{0, worlds::on_body(0, -kLength / 2 * Vec3::UnitY())},
                 {particles - 1, worlds::on_body(1, -kLength / 2 * Vec3::UnitY())}};
  for (Body& body : world.bodies) {
    body.spin = spin;
    body.velocity = velocity + spin.cross(body.position - height);
  }
  for (std::size_t i = 0; i < particles; ++i) {
    chain.velocity[i] = velocity + spin.cross(chain.position[i] - height);
  }
  world.connectors = {chain};
  const auto towards = [&](const Vec3& place) -> Vec3 {
    return (height - place).normalized() * dice.between(0.5, 3) + dice.within(0.3);
  };
  const Vec3 above = height + 0.5 * dice.direction();
  Connector rope =
      straight_connector("rope", 0.6, dice.scale(0.01, 0.2),
                         static_cast<std::size_t>(5 + dice.pick(20)), above, dice.direction());
  const Vec3 moves = towards(above);
  for (Vec3& each : rope.velocity) each = moves;
  world.connectors.push_back(rope);
  for (Connector& each : world.connectors) {
    each.radius = thick;
    each.pulls = kind.strings;
  }
  const Vec3 aside = height + 0.6 * dice.direction();
  stick(aside, dice.direction());
  world.bodies.back().velocity = towards(world.bodies.back().position);
  world.bodies.back().spin = dice.within(5);
  touch(world, kind.friction * dice.between(0, 1), kind.restitution * dice.between(0, 1));
  if (kind.bodies_touch)
    world.pairs = {{0, 1, 0.3, 0.3, 0.2}, {0, 2, 0.3, 0.3, 0.2}, {1, 2, 0.3, 0.3, 0.2}};
  if (kind.obstacles) {
    world.obstacles = {obstacle(plane_shape(), kind.friction, 0.3)};
    world.obstacles[0].place.position = Vec3(0, 0.4, 0);
    world.obstacles.push_back(post(0.1, Vec3(0.1, 0.6, 0), kind.friction));
  }
  finish(world);
  return world;
}

bool begins_inside(const World& world) {
  if (penetration_of_bodies(world) > 0 || contact::penetration_max(world) > 0) return true;
  return std::ranges::any_of(world.pairs, [&](const BodyPair& pair) {
    const auto capsule = [&](std::size_t b) {
      const Body& body = world.bodies[b];
      return contact::Capsule{body.point(body.capsule.from), body.point(body.capsule.to),
                              body.capsule.radius};
    };
    return contact::least_gap(capsule(pair.a), capsule(pair.b)) < 0;
  });
}

constexpr Kind kKinds[] = {
    {}, {1, 1}, {1, 1, true, true}, {1, 1, true, true, true}, {1, 1, true, true, false, true}};

/// Worlds of each kind in turn. Of many one may end by name: a stick that is pressed on a post with
/// its end and just beside it may find no response.
void weather(unsigned first, unsigned count, int frames) {
  std::string ended;
  unsigned ends = 0;
  for (unsigned seed = first; seed < first + count; ++seed) {
    const Kind& kind = kKinds[seed % std::size(kKinds)];
    const World world = storm(seed, kind);
    if (begins_inside(world)) continue;
    Simulation simulation(world, make_method("direct", {{"tolerance", 1e-3}}));
    try {
      for (int frame = 1; frame <= frames; ++frame) {
        simulation.advance_to(frame / 60.0);
        const World& now = simulation.world();
        ASSERT_LE(penetration_of_bodies(now), 1e-9) << seed << ' ' << frame;
        ASSERT_LE(contact::penetration_max(now), 1e-9) << seed << ' ' << frame;
        ASSERT_LT(stretch_max(now), 1e-6) << seed;
        if (kind.gravity) continue;
        const double scale = std::sqrt(energy_scale(world));
        ASSERT_LE((linear_momentum(now) - linear_momentum(world)).norm(), 1e-13 * scale) << seed;
        // Friction acts at the surface of a bead that does not turn.
        if (kind.friction > 0) continue;
        // Steps keep it as well as the tolerance asks.
        ASSERT_LE((angular_momentum(now) - angular_momentum(world)).norm(), 1e-4 * scale) << seed;
      }
    } catch (const Diverged& error) {
      ended += std::to_string(seed) + ": " + error.what() + "\n";
      ++ends;
    }
  }
  EXPECT_LE(ends, count / 100) << ended;
}

TEST(BeadsAtBodies, AStormOfFortyWorlds) {
  weather(1, 40, 22);
}

TEST(LongBeadsAtBodies, AStormOfFiveHundredWorlds) {
  weather(1, 500, 50);
}

}  // namespace
}  // namespace taut::bead_body_test
