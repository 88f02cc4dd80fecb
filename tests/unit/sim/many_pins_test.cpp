// Pins by the thousand: all of one time are set and released in one pass.
#include <gtest/gtest.h>

#include "sim/run/simulation.h"
#include "sim/world/obstacle.h"

namespace taut::many_pins_test {
namespace {

/// A rope in a bow, joined with another.
World ropes() {
  World world;
  for (const double side : {0.0, 0.3}) {
    Connector rope = straight_connector("rope", 1, 0.2, 11, Vec3(0, 0, side), Vec3(1, -1, 0));
    for (std::size_t i = 0; i < rope.particles(); ++i) {
      const double x = double(i) - 5;
      rope.position[i].z() = side + 0.02 * x * x;
      rope.velocity[i] = Vec3(0.1, 0.2, 0.3) * x;
    }
    rope.length = 0;
    for (std::size_t k = 0; k < rope.links(); ++k) {
      rope.rest[k] = (rope.position[k + 1] - rope.position[k]).norm();
      rope.length += rope.rest[k];
    }
    world.connectors.push_back(rope);
  }
  world.joints = {{{{0, 6}, {1, 5}}}};
  world.connectors[0].holds = {{0, {}}};
  finish(world);
  return world;
}

void expect_same(const World& a, const World& b) {
  EXPECT_EQ(a.topology, structure(a));
  ASSERT_EQ(a.connectors.size(), b.connectors.size());
  for (std::size_t c = 0; c < a.connectors.size(); ++c) {
    const Connector &first = a.connectors[c], &second = b.connectors[c];
    ASSERT_EQ(first.particles(), second.particles());
    ASSERT_EQ(first.holds.size(), second.holds.size());
    for (std::size_t i = 0; i < first.particles(); ++i) {
      EXPECT_LT((first.position[i] - second.position[i]).norm(), 1e-15);
      EXPECT_LT((first.velocity[i] - second.velocity[i]).norm(), 1e-15);
      EXPECT_EQ(first.particle_mass[i], second.particle_mass[i]);
    }
    for (std::size_t k = 0; k < first.links(); ++k) {
      EXPECT_NEAR(first.rest[k], second.rest[k], 1e-16);
    }
    for (std::size_t h = 0; h < first.holds.size(); ++h) {
      const PinRecord &one = first.holds[h].pin, &other = second.holds[h].pin;
      EXPECT_EQ(first.holds[h].particle, second.holds[h].particle);
      EXPECT_EQ(one.number, other.number);
      EXPECT_NEAR(one.fraction, other.fraction, 1e-15);
      EXPECT_NEAR(one.link_rest, other.link_rest, 1e-16);
    }
  }
  ASSERT_EQ(a.joints[0].particles.size(), b.joints[0].particles.size());
  for (std::size_t i = 0; i < a.joints[0].particles.size(); ++i) {
    EXPECT_EQ(a.joints[0].particles[i].particle, b.joints[0].particles[i].particle);
  }
}

/// A pin half the way from where `before` to where `behind` are along the connector.
NewPin between(const Connector& rope, double before, double at, double behind, double over) {
  const Vec3 from = material_point(rope, before).position;
  const Vec3 to = material_point(rope, behind).position;
  NewPin pin{at, Attachment{}, over};
  pin.to->point = from + (at - before) / (behind - before) * (to - from);
  return pin;
}

/// On the first rope: three on one link, one taken elsewhere with its particle and one drawn there.
std::vector<NewPin> pins(const World& world) {
  const Connector& rope = world.connectors[0];
  const double link = rope.rest[2], start = rope.rest[0] + rope.rest[1];
  const double particle = start + link + rope.rest[3];
  std::vector<NewPin> pins;
  for (const double part : {0.7, 0.3, 0.5}) pins.push_back({start + part * link, {}, 0});
  const double a = start + 0.7 * link, b = 0.55 * rope.length, c = 0.85 * rope.length;
  pins.push_back({c, {}, 0});
  pins.push_back({b, {}, 0});
  pins.push_back(between(rope, a, particle, b, 0));
  pins.push_back(between(rope, b, 0.7 * rope.length, c, 0.1));
  return pins;
}

TEST(ManyPins, AtOnceAreThoseOneAfterTheOther) {
  World single = ropes();
  Interventions one_by_one, at_once;
  ASSERT_EQ(one_by_one.pin(single, 0, 0.5 * (single.connectors[0].rest[0])).outcome,
            Outcome::done);  // stands on a link already
  World world = single;
  std::vector<std::uint64_t> numbers;
  const std::vector<NewPin> all = pins(world);
  for (const NewPin& pin : all) {
    const Pinned made = pin.to ? one_by_one.pin(single, 0, pin.along, *pin.to, pin.over)
                               : one_by_one.pin(single, 0, pin.along);
    ASSERT_EQ(made.outcome, Outcome::done) << words(made.outcome) << " at " << pin.along;
    numbers.push_back(made.pin);
  }
  ASSERT_EQ(at_once.pin(world, 0, all), numbers);
  expect_same(world, single);

  const std::vector some{numbers[0], numbers[2], numbers[3]};
  for (const std::uint64_t pin : some) {
    ASSERT_EQ(one_by_one.release(single, pin), Outcome::done);
  }
  ASSERT_EQ(at_once.release(world, 0, some), Outcome::done);
  expect_same(world, single);
}

TEST(ManyPins, ReleasedLaterLeaveTheLinksAtTheirLengths) {
  World world = ropes();
  Interventions interventions;
  const std::vector<double> rest = world.connectors[0].rest;
  const std::vector<std::uint64_t> numbers = interventions.pin(world, 0, pins(world));
  ASSERT_FALSE(numbers.empty());
  world.time = 1;
  place_held(world, 1);
  ASSERT_EQ(interventions.release(world, 0, numbers), Outcome::done);
  const Connector& rope = world.connectors[0];
  EXPECT_EQ(rope.rest, rest);
  EXPECT_EQ(rope.holds.size(), 1u);
  EXPECT_EQ(world.topology, structure(world));
  EXPECT_EQ(interventions.release(world, 0, numbers), Outcome::no_pin);
}

TEST(ManyPins, WhatIsRefusedChangesNothing) {
  World world = ropes();
  const World before = world;
  Interventions interventions;
  std::vector<NewPin> far = pins(world);
  far.push_back({0.3, Attachment{}, 0});
  far.back().to->point = Vec3(3, 0, 0);
  EXPECT_TRUE(interventions.pin(world, 0, far).empty());
  std::vector<NewPin> twice = pins(world);
  twice.push_back(twice.front());
  EXPECT_TRUE(interventions.pin(world, 0, twice).empty());
  expect_same(world, before);
  EXPECT_EQ(world.topology, before.topology);
  EXPECT_EQ(world.pins, before.pins);
}

TEST(ManyPins, AndCutsOfOneTimeSayWhichFreesABeadInsideOfAnObstacle) {
  World world;
  world.connectors = {straight_connector("rope", 1, 0.2, 11, Vec3::Zero(), Vec3::UnitX())};
  Obstacle ball;  // on a link, between its beads
  ball.name = "ball";
  ball.shape = sphere_shape(0.01);
  ball.place.position = Vec3(0.55, 0, 0);
  world.obstacles = {ball};
  world.gravity = Vec3::Zero();
  finish(world);
  const auto run = [&](double along) {
    Timeline timeline;
    timeline.cuts = {{0, 0.35, 0.5, {}}, {0, along, 0.5, {}}, {0, 0.65, 0.5, {}}};
    Simulation simulation(world, make_method("xpbd", {}), timeline);
    simulation.advance_to(1);
    return simulation.world().connectors.size();
  };
  EXPECT_EQ(run(0.45), 4u);
  try {
    run(0.55);
    FAIL() << "a bead is inside of the ball";
  } catch (const BadIntervention& error) {
    EXPECT_TRUE(error.flaw.cut);
    EXPECT_EQ(error.flaw.index, 1u);
  }
}

}  // namespace
}  // namespace taut::many_pins_test
