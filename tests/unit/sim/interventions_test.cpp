#include "sim/interventions/interventions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"

namespace taut::interventions_test {
namespace {

Attachment fixed(const Vec3& point) {
  return {Attachment::Kind::fixed, point, nullptr, 0};
}
Attachment on_body(std::size_t body, const Vec3& point) {
  return {Attachment::Kind::body, point, nullptr, body};
}

/// A rope of 1 m and 0.2 kg in mid-swing from the origin, and a stick that flies beside it.
World swinging_rope() {
  World world;
  Connector rope = straight_connector("rope", 1, 0.2, 11, Vec3::Zero(), Vec3(1, -1, 0));
  rope.holds = {{0, fixed(Vec3::Zero())}};
  world.connectors = {rope};
  Body stick;
  stick.mass_properties = solid_cylinder(0.3, 0.4, 0.03);
  stick.position = Vec3(0.5, -0.45, 0.05);
  stick.velocity = Vec3(0.2, 1, -0.3);
  stick.spin = Vec3(1, 5, 2);
  world.bodies = {stick};
  finish(world);
  make_method("impulse", {})->advance(world, 0.2);
  return world;
}

double total_mass(const World& world) {
  double mass = 0;
  for (const Connector& c : world.connectors) {
    mass = std::accumulate(c.particle_mass.begin(), c.particle_mass.end(), mass);
  }
  return mass;
}

TEST(Interventions, APinIsAHoldWhereTheConnectorIs) {
  World world = swinging_rope();
  const World before = world;
  Interventions interventions;
  const Pinned pinned = interventions.pin(world, 0, 0.44);
  ASSERT_EQ(pinned.outcome, Outcome::done);
  const Connector &is = world.connectors[0], &was = before.connectors[0];
  ASSERT_EQ(is.particles(), 12u);
  ASSERT_EQ(is.holds.size(), 2u);
  EXPECT_EQ(is.holds[1].particle, 5u);
  EXPECT_NEAR(is.rest[4], 0.04, 1e-15);
  EXPECT_NEAR(is.rest[5], 0.06, 1e-15);
  EXPECT_LT((is.position[5] - (0.6 * was.position[4] + 0.4 * was.position[5])).norm(), 1e-15);
  EXPECT_EQ(is.velocity[5], Vec3::Zero());
  EXPECT_NE(world.topology, before.topology);
  // All others keep their mass, their place and their momentum.
  EXPECT_EQ(total_mass(world), total_mass(before));
  EXPECT_EQ(linear_momentum(world), linear_momentum(before));
  for (std::size_t i = 0; i < 11; ++i) EXPECT_EQ(is.position[i + (i > 4)], was.position[i]);
}

TEST(Interventions, AtAParticleNoneIsAdded) {
  World world = swinging_rope();
  Interventions interventions;
  ASSERT_EQ(interventions.pin(world, 0, 0.3).outcome, Outcome::done);
  EXPECT_EQ(world.connectors[0].particles(), 11u);
  EXPECT_EQ(world.connectors[0].holds[1].particle, 3u);
  EXPECT_EQ(interventions.pin(world, 0, 1.0).outcome, Outcome::done);  // its free end
}

TEST(Interventions, APinAndItsReleaseBetweenTheSameStepsLeaveNoTrace) {
  for (const double along : {0.3, 0.44, 0.999, 1.0}) {
    for (const bool body : {false, true}) {
      World world = swinging_rope();
      const World before = world;
      Interventions interventions;
      const Vec3 there = material_point(world.connectors[0], along).position;
      const Attachment to = body ? on_body(0, world.bodies[0].rotation.conjugate() *
                                                  (there - world.bodies[0].frame().position))
                                 : fixed(there);
      const Pinned pinned = interventions.pin(world, 0, along, to);
      ASSERT_EQ(pinned.outcome, Outcome::done);
      ASSERT_EQ(interventions.release(world, pinned.pin), Outcome::done);
      EXPECT_EQ(state_hash(world), state_hash(before)) << along << body;
      EXPECT_EQ(world.topology, before.topology);
      EXPECT_EQ(world.connectors[0].rest, before.connectors[0].rest);
      EXPECT_EQ(world.connectors[0].particle_mass, before.connectors[0].particle_mass);
      EXPECT_EQ(world.bodies[0].mass_properties.inertia, before.bodies[0].mass_properties.inertia);
    }
  }
}

TEST(Interventions, SeveralPinsOnALinkComeAndGoInAnyOrder) {
  const World start = swinging_rope();
  std::vector<double> places = {0.44, 0.41, 0.47, 0.405, 0.4999, 0.52};
  std::sort(places.begin(), places.end());
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    World world = start;
    Interventions interventions;
    std::shuffle(places.begin(), places.end(), random);
    std::vector<std::uint64_t> pins;
    for (const double along : places) {
      const Pinned pinned = interventions.pin(world, 0, along);
      ASSERT_EQ(pinned.outcome, Outcome::done);
      pins.push_back(pinned.pin);
      const Connector& rope = world.connectors[0];
      EXPECT_NEAR(std::accumulate(rope.rest.begin(), rope.rest.end(), 0.0), 1, 1e-14);
    }
    EXPECT_EQ(world.connectors[0].particles(), 17u);
    std::shuffle(pins.begin(), pins.end(), random);
    for (const std::uint64_t pin : pins)
      ASSERT_EQ(interventions.release(world, pin), Outcome::done);
    EXPECT_EQ(world.connectors[0].rest, start.connectors[0].rest);
    EXPECT_EQ(state_hash(world), state_hash(start));
  }
}

TEST(Interventions, ReleaseRestoresTheLinkThatAPinHadBent) {
  World world = swinging_rope();
  const double mass = total_mass(world);
  Interventions interventions;
  const Pinned pinned = interventions.pin(world, 0, 0.45);
  const auto method = make_method("impulse", {{"step", 0.0005}, {"passes", 20.0}});
  method->advance(world, 0.6);  // the lower part swings on about the pin
  const Vec3 momentum = linear_momentum(world);
  const double bent = stretch_max(world);
  ASSERT_EQ(interventions.release(world, pinned.pin), Outcome::done);
  EXPECT_EQ(world.connectors[0].particles(), 11u);
  EXPECT_EQ(world.connectors[0].rest, swinging_rope().connectors[0].rest);
  EXPECT_EQ(total_mass(world), mass);
  EXPECT_EQ(linear_momentum(world), momentum);
  EXPECT_LT(stretch_max(world), 1e-9);
  EXPECT_LT(bent, 0.05);
  EXPECT_EQ(interventions.release(world, pinned.pin), Outcome::no_pin);
}

// A string may be shorter than it is long: nothing is to be restored.
TEST(Interventions, ReleaseLeavesAStringThatAPinHadBentAsItIs) {
  World world = swinging_rope();
  world.connectors[0].pulls = true;
  world.topology = structure(world);
  Interventions interventions;
  const Pinned pinned = interventions.pin(world, 0, 0.45);
  world.connectors[0].position[6] += Vec3(0.01, 0, 0.02);
  const std::vector<Vec3> bent = world.connectors[0].position;
  world.time += 0.1;
  ASSERT_EQ(interventions.release(world, pinned.pin), Outcome::done);
  const std::vector<Vec3>& now = world.connectors[0].position;
  ASSERT_EQ(now.size(), bent.size() - 1);
  for (std::size_t i = 0; i < now.size(); ++i) EXPECT_EQ(now[i], bent[i < 5 ? i : i + 1]) << i;
}

TEST(Interventions, AFreeBodyTakesTheMomentumOfWhatItCatches) {
  World world = swinging_rope();
  const Vec3 linear = linear_momentum(world), angular = angular_momentum(world);
  Interventions interventions;
  const Body& stick = world.bodies[0];
  const Vec3 there = world.connectors[0].position[5];
  const Vec3 point = stick.rotation.conjugate() * (there - stick.frame().position);
  const Pinned pinned = interventions.pin(world, 0, 0.5, on_body(0, point));
  ASSERT_EQ(pinned.outcome, Outcome::done);
  EXPECT_NEAR(stick.mass_properties.mass, 0.3 + 0.2 / 11, 1e-15);
  EXPECT_LT((linear_momentum(world) - linear).norm(), 1e-15);
  EXPECT_LT((angular_momentum(world) - angular).norm(), 1e-15);
  EXPECT_LT((world.connectors[0].velocity[5] - stick.point_velocity(point)).norm(), 1e-15);
  make_method("impulse", {})->advance(world, 0.3);
  const Vec3 later = linear_momentum(world), turning = angular_momentum(world);
  ASSERT_EQ(interventions.move(world, pinned.pin, on_body(0, point)), Outcome::done);
  EXPECT_LT((linear_momentum(world) - later).norm(), 1e-14);
  ASSERT_EQ(interventions.release(world, pinned.pin), Outcome::done);
  EXPECT_LT((linear_momentum(world) - later).norm(), 1e-14);
  EXPECT_LT((angular_momentum(world) - turning).norm(), 1e-14);
  EXPECT_EQ(stick.mass_properties.mass, 0.3);
}

TEST(Interventions, AParticleIsDrawnToItsPinSmoothly) {
  World world = swinging_rope();
  Interventions interventions;
  const Vec3 from = world.connectors[0].position[5], to = 0.8 * from + Vec3(0, 0, 0.05);
  ASSERT_EQ(interventions.pin(world, 0, 0.5, fixed(to), 0.2).outcome, Outcome::done);
  const auto& hold = world.connectors[0].holds[1].to;
  EXPECT_LT((hold_motion(world, hold, world.time).position - from).norm(), 1e-15);
  EXPECT_LT(hold_motion(world, hold, world.time).velocity.norm(), 1e-15);
  EXPECT_EQ(hold_motion(world, hold, world.time + 0.21).position, to);
  const double h = 1e-4;
  for (double t = world.time + 0.01; t < world.time + 0.2; t += 0.013) {
    const PointMotion a = hold_motion(world, hold, t - h), b = hold_motion(world, hold, t + h);
    const PointMotion now = hold_motion(world, hold, t);
    // Third and fourth derivatives of the quintic: at most 60 and 360 lags by the time's powers.
    EXPECT_LT(((b.position - a.position) / (2 * h) - now.velocity).norm(),
              h * h * 10 * 0.11 / 8e-3);
    EXPECT_LT(((b.velocity - a.velocity) / (2 * h) - now.acceleration).norm(),
              h * h * 60 * 0.11 / 1.6e-3);
  }
  make_method("impulse", {})->advance(world, 0.5);
  EXPECT_EQ(world.connectors[0].position[5], to);
}

TEST(Interventions, BadOnesSaySoAndChangeNothing) {
  World world = swinging_rope();
  Interventions interventions;
  const Pinned good = interventions.pin(world, 0, 0.5);
  const std::uint64_t state = state_hash(world), topology = world.topology;
  const double nan = std::nan("");
  const Vec3 near = world.connectors[0].position[7];
  const std::pair<Outcome, Outcome> expected[] = {
      {interventions.pin(world, 1, 0.5).outcome, Outcome::no_connector},
      {interventions.pin(world, 0, -0.1).outcome, Outcome::outside},
      {interventions.pin(world, 0, 1.1).outcome, Outcome::outside},
      {interventions.pin(world, 0, nan).outcome, Outcome::outside},
      {interventions.pin(world, 0, 0.5).outcome, Outcome::held_there},
      {interventions.pin(world, 0, 0.0).outcome, Outcome::held_there},
      {interventions.pin(world, 0, 0.7, fixed(Vec3(nan, 0, 0))).outcome, Outcome::no_target},
      {interventions.pin(world, 0, 0.7, on_body(3, near)).outcome, Outcome::no_target},
      {interventions.pin(world, 0, 0.7, {Attachment::Kind::path, near, nullptr, 0}).outcome,
       Outcome::no_target},
      {interventions.pin(world, 0, 0.6, fixed(Vec3(0, 2, 0))).outcome, Outcome::out_of_reach},
      {interventions.move(world, good.pin, fixed(Vec3(0.51, 0, 0))), Outcome::out_of_reach},
      {interventions.move(world, 17, fixed(near)), Outcome::no_pin},
      {interventions.release(world, 0), Outcome::no_pin},
      {interventions.release(world, 17), Outcome::no_pin},
      {interventions.cut(world, 2, 0.5).outcome, Outcome::no_connector},
      {interventions.cut(world, 0, 0.0).outcome, Outcome::outside},
      {interventions.cut(world, 0, 1.0).outcome, Outcome::outside},
      {interventions.cut(world, 0, nan).outcome, Outcome::outside},
      {interventions.cut(world, 0, 0.5).outcome, Outcome::held_there},
  };
  for (const auto& [outcome, wanted] : expected) {
    EXPECT_EQ(outcome, wanted) << words(wanted);
    EXPECT_FALSE(words(outcome).empty());
  }
  EXPECT_EQ(state_hash(world), state);
  EXPECT_EQ(world.topology, topology);
}

TEST(Interventions, ACutLosesNothing) {
  for (const double along : {0.3, 0.44, 0.01}) {
    World world = swinging_rope();
    const double mass = total_mass(world);
    const Vec3 momentum = linear_momentum(world);
    Interventions interventions;
    const Pinned low = interventions.pin(world, 0, 0.84);
    const Vec3 place = material_point(world.connectors[0], along).position;
    const Divided divided = interventions.cut(world, 0, along);
    ASSERT_EQ(divided.outcome, Outcome::done);
    ASSERT_EQ(divided.connector, 1u);
    const Connector &first = world.connectors[0], &second = world.connectors[1];
    EXPECT_NEAR(total_mass(world), mass, 1e-16);
    EXPECT_NEAR(first.mass + second.mass, 0.2, 1e-16);
    EXPECT_LT((linear_momentum(world) - momentum).norm(), 1e-16);
    EXPECT_NEAR(first.length, along, 1e-15);
    EXPECT_NEAR(first.length + second.length, 1, 1e-15);
    EXPECT_NEAR(std::accumulate(first.rest.begin(), first.rest.end(), 0.0), along, 1e-15);
    EXPECT_NEAR(std::accumulate(second.rest.begin(), second.rest.end(), 0.0), 1 - along, 1e-15);
    EXPECT_LT((first.position.back() - place).norm(), 1e-9);
    EXPECT_EQ(first.position.back(), second.position.front());
    EXPECT_EQ(first.particle_mass.size(), first.particles());
    for (const double m : first.particle_mass) EXPECT_GT(m, 0);
    ASSERT_EQ(second.holds.size(), 1u);
    EXPECT_EQ(second.particles(), second.links() + 1);
    EXPECT_EQ(interventions.release(world, low.pin), Outcome::done);
    // The lower part falls, the upper one swings on.
    make_method("impulse", {})->advance(world, 0.5);
    EXPECT_GT((world.connectors[0].position.back() - world.connectors[1].position.front()).norm(),
              0.1);
  }
}

TEST(Interventions, ACutThroughAPinnedLinkKeepsItsPins) {
  World world = swinging_rope();
  Interventions interventions;
  const Pinned before = interventions.pin(world, 0, 0.42),
               after = interventions.pin(world, 0, 0.48);
  ASSERT_EQ(interventions.cut(world, 0, 0.45).outcome, Outcome::done);
  world.time += 1;  // so that releases are not undone
  ASSERT_EQ(interventions.release(world, before.pin), Outcome::done);
  ASSERT_EQ(interventions.release(world, after.pin), Outcome::done);
  EXPECT_NEAR(world.connectors[0].rest.back(), 0.05, 1e-15);
  EXPECT_NEAR(world.connectors[1].rest.front(), 0.05, 1e-15);
}

TEST(Interventions, PartsHaveNamesOfTheirOwn) {
  World world = swinging_rope();
  Interventions interventions;
  const std::pair<std::size_t, double> cuts[] = {{0, 0.85}, {0, 0.65}, {1, 0.05}, {0, 0.35}};
  for (const auto& [connector, along] : cuts) {
    ASSERT_EQ(interventions.cut(world, connector, along).outcome, Outcome::done);
  }
  std::vector<std::string> names;
  for (const Connector& connector : world.connectors) names.push_back(connector.name);
  const std::vector<std::string> expected = {"rope", "rope'", "rope''", "rope'''", "rope'4"};
  EXPECT_EQ(names, expected);
}

/// Three ropes, of which the second is joined to the first and holds a stick.
World tied_ropes() {
  World world = swinging_rope();
  const Vec3 side(0, 0, 2);
  for (const double apart : {0.0, 1.0}) {
    Connector rope = straight_connector("rope", 1, 0.2, 11, apart * side, Vec3(1, -1, 0));
    rope.holds = {{0, fixed(apart * side)}};
    world.connectors.push_back(rope);
  }
  Connector& second = world.connectors[1];
  const Vec3 gap = world.connectors[0].position[4] - second.position[0];
  for (Vec3& position : second.position) position += gap;
  second.holds = {{10, on_body(0, Vec3(0, 0.2, 0))}};
  world.joints = {{{{0, 4}, {1, 0}}}};
  world.topology = 0;
  finish(world);
  return world;
}

TEST(Interventions, TheTopologyIsThatOfTheWorldAnew) {
  World world = tied_ropes();
  Interventions interventions;
  std::mt19937 chance(3);
  const auto draw = [&](double most) { return std::uniform_real_distribution(0.0, most)(chance); };
  std::vector<std::uint64_t> pins;
  int done = 0;
  for (int i = 0; i < 300; ++i) {
    const auto connector = static_cast<std::size_t>(draw(double(world.connectors.size())));
    const double along = draw(world.connectors[connector].length);
    const double what = draw(1);
    const std::uint64_t before = world.topology;
    Outcome outcome = Outcome::done;
    if (what < 0.4) {
      const PointMotion there = material_point(world.connectors[connector], along);
      const bool body = what < 0.1;
      const Attachment to = body ? on_body(0, Vec3(0, 0.1, 0)) : fixed(there.position);
      const Pinned pinned = interventions.pin(world, connector, along, to, body ? 0 : draw(0.1));
      outcome = pinned.outcome;
      if (outcome == Outcome::done) pins.push_back(pinned.pin);
    } else if (what < 0.8 && !pins.empty()) {
      const auto k = static_cast<std::ptrdiff_t>(draw(double(pins.size())));
      const std::uint64_t pin = pins[static_cast<std::size_t>(k)];
      if (what < 0.5) {
        outcome = interventions.move(world, pin, on_body(0, Vec3(0, draw(0.2), 0)));
      } else {
        outcome = interventions.release(world, pin, connector);
        if (outcome == Outcome::done) pins.erase(pins.begin() + k);
      }
    } else if (what > 0.95) {
      outcome = interventions.cut(world, connector, along).outcome;
    } else {
      continue;
    }
    world.time += 1e-3;
    done += outcome == Outcome::done;
    EXPECT_EQ(world.topology == before, outcome != Outcome::done);
    ASSERT_EQ(world.topology, structure(world)) << i << " " << words(outcome);
  }
  EXPECT_GT(done, 100);
  EXPECT_GT(world.connectors.size(), 4u);
}

// Or thousands of them would take time with the square of their number.
TEST(Interventions, LookAtNoOtherConnectorForTheTopology) {
  World world = tied_ropes(), other = world;
  other.connectors[2].rest[3] *= 2;  // by hand, and nobody has taken the topology anew
  Interventions interventions, same;
  const std::uint64_t before = world.topology;
  ASSERT_EQ(interventions.pin(world, 0, 0.2).outcome, Outcome::done);
  ASSERT_EQ(same.pin(other, 0, 0.2).outcome, Outcome::done);
  EXPECT_NE(world.topology, before);
  EXPECT_EQ(other.topology, world.topology);
  EXPECT_NE(other.topology, structure(other));
}

}  // namespace
}  // namespace taut::interventions_test
