// Known answers for the forces in a state, and their balance.
#include "sim/run/forces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "sim/topology/components.h"
#include "tests/physics/contact/contact_worlds.h"
#include "tests/physics/material/material_worlds.h"
#include "tests/physics/worlds.h"

namespace taut::forces_test {
namespace {

using worlds::kGravity;
using worlds::total_mass;

World run(const World& world, double until, double tolerance = 1e-8) {
  Simulation simulation(world, make_method("direct", {{"tolerance", tolerance}}));
  simulation.advance_to(until);
  return simulation.world();
}

/// The force of all that is outside: of holds but those of free bodies, and of obstacles.
Vec3 from_outside(const World& world, const Forces& forces) {
  Vec3 sum = Vec3::Zero();
  for (const Forces::Hold& hold : forces.holds) {
    const Attachment& to = find_hold(world.connectors[hold.connector], hold.particle)->to;
    const bool inside = to.kind == Attachment::Kind::body && !world.bodies[to.body].driven();
    if (!inside) sum += hold.force;
  }
  for (const Forces::Contact& contact : forces.contacts) {
    if (contact.other.kind == Forces::Side::Kind::obstacle) sum += contact.force;
  }
  return sum;
}

/// What is missing (N) for the forces from outside and the weight to change the momentum as it
/// changes within 2 `apart` (s).
double out_of_balance(const World& world, double time, double apart) {
  const World now = run(world, time);
  const Vec3 change =
      (linear_momentum(run(world, time + apart)) - linear_momentum(run(world, time - apart))) /
      (2 * apart);
  return (from_outside(now, forces_of(now)) + total_mass(now) * now.gravity - change).norm();
}

TEST(Forces, OfASwingAreThoseOfHuygens) {
  const World start = worlds::pendulum(0.5, 70);
  for (const double time : {0.0, 0.2, 0.43, 1.1}) {
    const World world = run(start, time);
    const Connector& bob = world.connectors[0];
    const double mass = bob.particle_mass[1], top = bob.particle_mass[0];
    const Vec3 along = bob.position[1] / 0.5;
    const double pull = mass * (bob.velocity[1].squaredNorm() / 0.5 - kGravity * along.y());
    const Forces forces = forces_of(world);
    ASSERT_EQ(forces.links.size(), 1u);
    EXPECT_NEAR(forces.links[0].tension, pull, 1e-5 * pull) << time;
    ASSERT_EQ(forces.holds.size(), 1u);
    const Vec3 held = top * kGravity * Vec3::UnitY() - pull * along;
    EXPECT_LT((forces.holds[0].force - held).norm(), 1e-5 * pull) << time;
  }
}

TEST(Forces, OfAHangingChainCarryWhatIsBelow) {
  const World world = worlds::chain(11, 1, -Vec3::UnitY());
  const Forces forces = forces_of(world);
  ASSERT_EQ(forces.links.size(), 10u);
  double below = 0;
  for (std::size_t k = 10; k-- > 0;) {
    below += world.connectors[0].particle_mass[k + 1] * kGravity;
    EXPECT_NEAR(forces.links[k].tension, below, 1e-6 * below);
    EXPECT_EQ(forces.links[k].link, k);
  }
  EXPECT_NEAR(forces.holds[0].force.y(), total_mass(world) * kGravity, 1e-5);
}

// Of a bead pair on a slope: at rest below the angle of friction, sliding above it.
TEST(Forces, OfASlopeAreNewtonsAndCoulombs) {
  for (const double friction : {0.0, 0.3, 1.0}) {
    const double angle = 0.5;
    Obstacle slope = contact_worlds::obstacle(plane_shape(), friction);
    slope.place.rotation = Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
    const Vec3 normal = slope.place.rotation * Vec3::UnitY();
    World start = contact_worlds::pair(0.01 * normal, Vec3::Zero(), slope);
    start.connectors[0].radius = 0.01;
    const World world = run(start, 0.3);
    const Forces forces = forces_of(world);
    ASSERT_EQ(forces.contacts.size(), 2u) << friction;
    const double weight = total_mass(world) * kGravity / 2;
    const double most = friction * weight * std::cos(angle);
    for (const Forces::Contact& contact : forces.contacts) {
      EXPECT_EQ(contact.one.kind, Forces::Side::Kind::particle);
      EXPECT_EQ(contact.other.kind, Forces::Side::Kind::obstacle);
      EXPECT_NEAR(contact.force.dot(normal), weight * std::cos(angle), 1e-6 * weight);
      const double across = (contact.force - contact.force.dot(normal) * normal).norm();
      EXPECT_NEAR(across, std::min(most, weight * std::sin(angle)), 1e-5 * weight) << friction;
      EXPECT_NEAR(contact.place.dot(normal), 0, 1e-6);
    }
  }
}

TEST(Forces, BalanceWeightAndInertia) {
  EXPECT_LT(out_of_balance(worlds::chain_with_box(9), 0.3, 1e-4), 1e-3);
  EXPECT_LT(out_of_balance(worlds::thrown(9), 0.2, 1e-4), 1e-3);
  EXPECT_LT(out_of_balance(worlds::garland(), 0.3, 1e-4), 1e-3);
  const World bends =
      material_worlds::rope(12, 0.2, material_worlds::section(material_worlds::kRigid, 0.05), true);
  EXPECT_LT(out_of_balance(bends, 0.3, 1e-4), 1e-3);
  const World stretches = material_worlds::rope(12, 0.2, material_worlds::section(50, 0.05), true);
  EXPECT_LT(out_of_balance(stretches, 0.3, 1e-4), 1e-3);
}

// Obstacles carry the weight of a rope at rest over a post, with and without friction.
TEST(Forces, OfARopeOverAPostCarryIt) {
  for (const double friction : {0.0, 0.3}) {
    const World start = contact_worlds::over_post(8, 0, 6, 7, 0.05, 0.5, friction);
    EXPECT_LT(out_of_balance(start, 0.2, 1e-4), 1e-3) << friction;
  }
}

// A method that stretches links leaves them at other lengths: of a weight at rest on springs.
TEST(Forces, OfStretchedLinksAreThoseOfTheirLengths) {
  World world = worlds::chain(5, 1, -Vec3::UnitY());
  Connector& chain = world.connectors[0];
  for (std::size_t i = 0; i < chain.particles(); ++i) chain.position[i] *= 1.3;
  const Forces forces = forces_of(world);
  const double weight = (1 - chain.particle_mass[0]) * kGravity;
  EXPECT_NEAR(forces.links[0].tension, weight, 1e-6 * weight);
}

// A clamp bears the moments of all weights about it. At rest, or nearly: inertia counts as weight.
TEST(Forces, OfAClampBearMomentsOfWeights) {
  Connector rod = straight_connector("rod", 1, 0.1, 21, Vec3::Zero(), Vec3::UnitX());
  rod.sections.assign(rod.links(), {.bending_stiffness = 2, .bending_damping = 0.2});
  rod.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  rod.holds[0].clamp = Vec3::UnitX();
  World world;
  world.connectors = {rod};
  finish(world);
  const World rest = run(world, 4, 1e-6);
  const Connector& at = rest.connectors[0];
  Vec3 moments = Vec3::Zero();
  for (std::size_t i = 0; i < at.particles(); ++i)
    moments += at.particle_mass[i] * at.position[i].cross(rest.gravity);
  const Forces forces = forces_of(rest);
  ASSERT_EQ(forces.holds.size(), 1u);
  EXPECT_NEAR(moments.z(), -0.1 * kGravity / 2, 0.02);
  EXPECT_LT((forces.holds[0].moment + moments).norm(), 1e-3 * moments.norm());
}

// A rod that is twisted by an angle between two clamps has the moment GJ angle / L at both.
TEST(Forces, OfClampsTwistARod) {
  constexpr double kAngle = 0.8, kStiffness = 0.3;
  Connector rod = straight_connector("rod", 0.5, 0.1, 11, Vec3::Zero(), Vec3::UnitX());
  rod.sections.assign(rod.links(), {.bending_stiffness = 1, .twisting_stiffness = kStiffness});
  for (Section& section : rod.sections) section.rest_twist = -kAngle / 0.5;
  rod.holds = {{0, worlds::fixed_at(Vec3::Zero())}, {10, worlds::fixed_at(rod.position.back())}};
  for (Hold& hold : rod.holds) hold.clamp = Vec3::UnitX();
  World world;
  world.gravity.setZero();
  world.connectors = {rod};
  finish(world);
  const Forces forces = forces_of(world);
  ASSERT_EQ(forces.holds.size(), 2u);
  const Vec3 moment = kStiffness * kAngle / 0.5 * Vec3::UnitX();
  EXPECT_LT((forces.holds[0].moment + moment).norm(), 1e-9);
  EXPECT_LT((forces.holds[1].moment - moment).norm(), 1e-9);
}

// A body on a hinge, which is a link without a length: three conditions in one.
TEST(Forces, OfAHingeCarryTheBody) {
  World world;
  Body body = worlds::box("box");
  body.spin.setZero();
  body.position = Vec3(0, -0.1, 0);
  world.bodies = {body};
  Connector hinge = straight_connector("hinge", 0, 0, 2, Vec3::Zero(), Vec3::UnitY());
  hinge.holds = {{0, worlds::fixed_at(Vec3::Zero())}, {1, worlds::on_body(0, Vec3(0, 0.1, 0))}};
  world.connectors = {hinge};
  finish(world);
  const Forces forces = forces_of(world);
  const double weight = 0.3 * kGravity;
  ASSERT_EQ(forces.links.size(), 1u);
  EXPECT_NEAR(forces.links[0].tension, weight, 1e-6 * weight);
  ASSERT_EQ(forces.holds.size(), 2u);
  EXPECT_NEAR(forces.holds[0].force.y(), weight, 1e-6 * weight);
  EXPECT_NEAR(forces.holds[1].force.y(), -weight, 1e-6 * weight);
}

// A light chain carries a weight, or is refused where rounding leaves no digit of the forces.
TEST(Forces, OfHeavyLoadsAreRightOrRefused) {
  for (const double load : {1e3, 1e6, 1e9, 1e12, 1e15}) {
    World world = worlds::chain(5, 1, -Vec3::UnitY());
    world.connectors[0].particle_mass.back() = load;
    finish(world);
    try {
      const double near = (load < 1e9 ? 1e-6 : 1e-2) * load * kGravity;
      EXPECT_NEAR(forces_of(world).links.back().tension, load * kGravity, near);
    } catch (const Diverged&) {
      EXPECT_GE(load, 1e9);
    }
  }
}

TEST(Forces, OfNothingAndOfNoNumbersAreNone) {
  World nothing;
  finish(nothing);
  EXPECT_TRUE(forces_of(nothing).links.empty());
  World weightless = worlds::pendulum(0.5, 70);
  weightless.gravity.setZero();
  EXPECT_NEAR(forces_of(weightless).links[0].tension, 0, 1e-12);
  World broken = worlds::pendulum(0.5, 70);
  broken.connectors[0].velocity[1].x() = std::nan("");
  EXPECT_THROW(forces_of(broken), Diverged);
}

std::vector<Event> events_of(const World& world, double until) {
  Simulation simulation(world, make_method("direct", {{"tolerance", 1e-6}}));
  std::vector<Event> all;
  for (int frame = 1; frame <= 20; ++frame) {
    simulation.advance_to(until * frame / 20);
    for (const Event& event : simulation.take_events()) {
      EXPECT_LE(event.time, until * frame / 20);
      EXPECT_GT(event.time, until * (frame - 1) / 20);
      all.push_back(event);
    }
  }
  return all;
}

// Two beads, which fall 0.2 m and bounce with half of their speed.
TEST(Events, HitsComeWhenTheyMustWithTheirImpulse) {
  Obstacle floor = contact_worlds::obstacle(plane_shape(), 0, 0.5);
  World world = contact_worlds::pair(Vec3(0, 0.21, 0), Vec3::Zero(), floor);
  world.connectors[0].radius = 0.01;
  const double fall = std::sqrt(2 * 0.2 / kGravity), speed = kGravity * fall;
  const std::vector<Event> events = events_of(world, 2.4 * fall);
  ASSERT_EQ(events.size(), 4u);  // both beads, twice
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(events[i].kind, Event::Kind::hit);
    EXPECT_TRUE(events[i].of_contact);
    EXPECT_EQ(events[i].one.kind, Forces::Side::Kind::particle);
    EXPECT_EQ(events[i].one.at, i % 2);
    EXPECT_EQ(events[i].other.kind, Forces::Side::Kind::obstacle);
    const double strikes = i < 2 ? speed : speed / 2;
    EXPECT_NEAR(events[i].time, i < 2 ? fall : 2 * fall, 1e-5);
    EXPECT_NEAR(events[i].size, 1.5 * strikes * 0.1, 1e-5);
    EXPECT_NEAR(events[i].place.y(), 0, 1e-6);
  }
}

// Two beads slide over a floor until friction stops them.
TEST(Events, WhatSlidesComesToStick) {
  Obstacle floor = contact_worlds::obstacle(plane_shape(), 0.4);
  World world = contact_worlds::pair(Vec3(0, 0.01, 0), Vec3(2, 0, 0), floor);
  world.connectors[0].radius = 0.01;
  std::vector<Event> sticks;
  for (const Event& event : events_of(world, 0.8)) {
    if (event.kind == Event::Kind::stick) sticks.push_back(event);
    EXPECT_NE(event.kind, Event::Kind::slide);
    EXPECT_NE(event.kind, Event::Kind::leave);
  }
  ASSERT_EQ(sticks.size(), 2u);
  const double stop = 2 / (0.4 * kGravity);
  for (const Event& event : sticks) {
    EXPECT_NEAR(event.time, stop, 1e-4);
    EXPECT_NEAR(event.place.x(), 2 * stop / 2, 1e-4);
  }
}

// A bead falls past the point that its string is fixed to.
TEST(Events, AStringGoesTautWithAnImpulse) {
  World world = worlds::chain(2, 1, Vec3::UnitY());
  world.connectors[0].pulls = true;
  finish(world);
  const double fall = std::sqrt(2 * 2 / kGravity), mass = world.connectors[0].particle_mass[1];
  const std::vector<Event> events = events_of(world, 1.2 * fall);
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].kind, Event::Kind::slack);
  EXPECT_EQ(events[1].kind, Event::Kind::taut);
  EXPECT_NEAR(events[1].time, fall, 1e-5);
  EXPECT_EQ(events[2].kind, Event::Kind::impulse);
  EXPECT_EQ(events[2].time, events[1].time);
  EXPECT_NEAR(events[2].size, mass * kGravity * fall, 1e-5);
}

}  // namespace
}  // namespace taut::forces_test
