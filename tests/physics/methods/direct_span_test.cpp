// Massless spans by the direct method against known answers.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/measure/measure.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::direct_span_test {
namespace {

using worlds::kGravity;

constexpr double kLength = 0.5, kMass = 0.2;  // m, kg

/// A point mass on a massless span from the origin.
World weight_at(const Vec3& place, const Vec3& velocity, double restitution) {
  World world;
  Connector cord = straight_connector("cord", kLength, 0, 6, Vec3::Zero(), -Vec3::UnitY());
  cord.model = ConnectorModel::span;
  cord.restitution = restitution;
  cord.particle_mass.back() = kMass;
  cord.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  for (std::size_t k = 0; k <= 5; ++k) {
    cord.position[k] = static_cast<double>(k) / 5 * place;
    cord.velocity[k] = static_cast<double>(k) / 5 * velocity;
  }
  world.connectors = {cord};
  finish(world);
  return world;
}

Simulation direct(const World& world) {
  return {world, make_method("direct", {{"tolerance", 1e-8}})};
}

const Event* first(const Method& method, Event::Kind kind) {
  for (const Event& event : method.events()) {
    if (event.kind == kind) return &event;
  }
  return nullptr;
}

TEST(DirectSpan, AFallIsFreeUntilTheSpanIsTautAndReboundsAsStated) {
  for (const double restitution : {0.0, 0.3, 0.8}) {
    Simulation simulation = direct(weight_at(Vec3(0, -0.1, 0), Vec3::Zero(), restitution));
    const double fall = std::sqrt(2 * (kLength - 0.1) / kGravity), speed = kGravity * fall;
    const double later = 0.01;  // s, before it would be taut again
    simulation.advance_to(fall + later);
    const Event* taut = first(simulation.method(), Event::Kind::taut);
    const Event* impulse = first(simulation.method(), Event::Kind::impulse);
    ASSERT_TRUE(taut && impulse) << restitution;
    EXPECT_NEAR(taut->time, fall, 1e-8);
    EXPECT_NEAR(impulse->size, kMass * (1 + restitution) * speed, 1e-6);
    const double back = restitution * speed;
    const double height =
        back > 0 ? -kLength + back * later - kGravity * later * later / 2 : -kLength;
    EXPECT_NEAR(simulation.world().connectors[0].position[5].y(), height, 1e-7) << restitution;
  }
}

// On a circle with the speed v at its bottom the tension is zero at the height (v^2 + g l) / 3g
// above it.
TEST(DirectSpan, AWeightLeavesTheCircleWhereTheTensionIsZero) {
  const double speed = std::sqrt(3.5 * kGravity * kLength);
  const World start = weight_at(Vec3(0, -kLength, 0), Vec3(speed, 0, 0), 0);
  Simulation scout = direct(start);
  scout.advance_to(0.6);
  const Event* slack = first(scout.method(), Event::Kind::slack);
  ASSERT_TRUE(slack);
  Simulation simulation = direct(start);
  simulation.advance_to(slack->time);
  const Vec3 place = simulation.world().connectors[0].position[5];
  EXPECT_NEAR(place.y() + kLength, (speed * speed / kGravity + kLength) / 3, 1e-6);
  EXPECT_NEAR(place.norm(), kLength, 1e-9);
}

TEST(DirectSpan, BodiesKeepTheirMomentumAndLoseWhatTheRestitutionTakes) {
  constexpr double restitution = 0.4;
  World world;
  world.gravity.setZero();
  world.bodies = {worlds::box("a"), worlds::box("b")};
  for (Body& body : world.bodies) body.spin.setZero();
  world.bodies[0].position = Vec3::Zero(), world.bodies[0].velocity = Vec3::Zero();
  world.bodies[1].position = Vec3(0.3, 0, 0), world.bodies[1].velocity = Vec3(2, 0, 0);
  for (Body& body : world.bodies) body.mass_properties.centre.setZero();
  Connector cord = straight_connector("cord", kLength, 0, 3, Vec3::Zero(), Vec3::UnitX());
  cord.model = ConnectorModel::span;
  cord.restitution = restitution;
  cord.holds = {{0, worlds::on_body(0, Vec3::Zero())}, {2, worlds::on_body(1, Vec3::Zero())}};
  world.connectors = {cord};
  finish(world);
  const Vec3 linear = linear_momentum(world), angular = angular_momentum(world);
  const double before = kinetic_energy(world);
  Simulation simulation = direct(world);
  simulation.advance_to(0.2);  // taut at 0.1 s
  const World& now = simulation.world();
  EXPECT_LT((linear_momentum(now) - linear).norm(), 1e-13 * linear.norm());
  EXPECT_LT((angular_momentum(now) - angular).norm(), 1e-13 * linear.norm());
  const double a = world.bodies[0].mass_properties.mass, b = world.bodies[1].mass_properties.mass;
  const double loss = a * b / (a + b) * 4 * (1 - restitution * restitution) / 2;
  EXPECT_NEAR(before - kinetic_energy(now), loss, 1e-9 * before);
}

// A stick thrown back by its end turns, and its end is soon drawn away again: rebounds that get
// shorter and shorter.
TEST(DirectSpan, ReboundsComeToAnEndWithoutGravityToo) {
  World world;
  world.gravity.setZero();
  Body stick, box;
  stick.mass_properties = solid_cylinder(0.12, 0.3, 0.028);
  stick.position = Vec3(-0.3, -0.1, 0);
  stick.velocity = Vec3(-0.5, 0, 0);
  box.mass_properties = solid_box(0.24, Vec3(0.1, 0.1, 0.1));
  box.position = Vec3(0.15, 0, 0);
  box.velocity = Vec3(0.5, 0.2, 0);
  world.bodies = {stick, box};
  Connector cord = straight_connector("cord", 0.5, 0, 11, Vec3::Zero(), Vec3::UnitX());
  cord.model = ConnectorModel::span;
  cord.restitution = 0.3;
  cord.holds = {{0, worlds::on_body(0, Vec3(0, 0.15, 0))},
                {10, worlds::on_body(1, Vec3(-0.05, 0, 0))}};
  world.connectors = {cord};
  finish(world);
  const Vec3 linear = linear_momentum(world), angular = angular_momentum(world);
  Simulation simulation = direct(world);
  simulation.advance_to(2.0);
  EXPECT_TRUE(first(simulation.method(), Event::Kind::taut));
  EXPECT_LT(simulation.method().events().size(), 200u);
  EXPECT_LT((linear_momentum(simulation.world()) - linear).norm(), 1e-12 * linear.norm());
  EXPECT_LT((angular_momentum(simulation.world()) - angular).norm(),
            1e-12 * linear.norm());  // times a metre
}

// The reduced model leaves out the rope's own inertia and weight.
TEST(DirectSpan, DiffersFromLinksByTheWeightOfTheRope) {
  const auto swing = [](double mass, ConnectorModel model) {
    World world = worlds::chain(11, kLength, Vec3::UnitX(), mass);
    world.connectors[0].model = model;
    world.connectors[0].particle_mass.back() += kMass;
    finish(world);
    Simulation simulation = direct(world);
    simulation.advance_to(0.25);
    return simulation.world().connectors[0].position[10];
  };
  double before = 1;
  for (const double mass : {0.05, 0.005, 0.0005}) {
    const double apart =
        (swing(mass, ConnectorModel::links) - swing(mass, ConnectorModel::span)).norm();
    EXPECT_LT(apart, 0.3 * before);  // the first order in the rope's mass
    EXPECT_GT(apart, 0.01 * before * mass);
    before = apart;
  }
}

}  // namespace
}  // namespace taut::direct_span_test
