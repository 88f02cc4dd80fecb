// The impulse of a cord that goes taut: restitution, momentum, and the form as printed.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "tests/physics/methods/impulse_worlds.h"

namespace taut::impulse_impact_test {
namespace {

/// The impact of a cord on the ends that it stops: the worlds before and after, and the kinetic
/// energy lost.
struct Impact {
  World before, after;
  Vec3 along;  // from the first end to the last, when the cord went taut
  double lost = 0;
};

Vec3 end_velocity(const World& world, const Hold& hold) {
  return hold_motion(world, hold.to, world.time).velocity;
}

double separation_speed(const World& world, const Vec3& along) {
  const auto& holds = world.connectors[0].holds;
  return along.dot(end_velocity(world, holds[1]) - end_velocity(world, holds[0]));
}

/// Advances a world without gravity until its cord has gone taut.
Impact impact(World world, const Settings& settings) {
  world.gravity = Vec3::Zero();
  finish(world);
  const auto method = make_method("impulse", settings);
  Impact result;
  for (int k = 1; k <= 1000; ++k) {
    result.before = world;
    method->advance(world, k * 1e-4);
    if (!method->events().empty()) break;
  }
  const Connector& line = result.before.connectors[0];
  // Free flight from `before` to the moment of the impact; both ends move almost straight.
  const double ago = method->events().at(0).time - result.before.time;
  result.along = (line.position.back() + ago * line.velocity.back() - line.position.front() -
                  ago * line.velocity.front())
                     .normalized();
  result.lost = kinetic_energy(result.before) - kinetic_energy(world);
  result.after = world;
  return result;
}

/// The mass with which two ends resist separation along n: 1 / sum of n.(1/m + (I^-1 (r x n)) x r).
double reduced_mass(const World& world, const Vec3& along) {
  double inverse = 0;
  for (const Hold& hold : world.connectors[0].holds) {
    if (is_prescribed(world, hold.to)) continue;
    const Body& body = world.bodies[hold.to.body];
    const Vec3 arm = body.point(hold.to.point) - body.position;
    const Vec3 turned = body.world_inertia().inverse() * arm.cross(along);
    inverse += 1 / body.mass_properties.mass + along.dot(turned.cross(arm));
  }
  return 1 / inverse;
}

World stick_on_a_fixed_cord(double restitution) {
  World world;
  world.bodies = {stick(Vec3(0.05, -0.1, 0.02), Vec3(0.4, -2, 0.3), Vec3(3, 2, -5))};
  Connector line = cord(0.2, 0, 5, Vec3(0, 0.15, 0), world.bodies[0].point(Vec3(0, 0.15, 0.01)));
  line.holds = {{0, fixed(Vec3(0, 0.15, 0))}, {4, on_body(0, Vec3(0, 0.15, 0.01))}};
  line.restitution = restitution;
  world.connectors = {line};
  return world;
}

TEST(Impulse, AGoingTautReversesThePartingByTheRestitution) {
  for (const double restitution : {0.0, 0.3, 1.0}) {
    for (const World& world : {stick_on_a_fixed_cord(restitution), two_sticks(restitution)}) {
      const Impact hit = impact(world, {{"step", 1e-4}});
      const double before = separation_speed(hit.before, hit.along),
                   after = separation_speed(hit.after, hit.along);
      ASSERT_GT(before, 0.5);
      // The bodies turn by up to spin * step = 6e-4 rad within the step of the impact.
      EXPECT_NEAR(after, -restitution * before, 2e-3 * before);
      const double loss = reduced_mass(hit.before, hit.along) * before * before *
                          (1 - restitution * restitution) / 2;
      EXPECT_NEAR(hit.lost, loss, 3e-3 * kinetic_energy(hit.before));
    }
  }
}

TEST(Impulse, TwoFreeBodiesKeepTheirMomentum) {
  for (const double restitution : {0.0, 0.6}) {
    World world = two_sticks(restitution);
    world.gravity = Vec3::Zero();
    finish(world);
    const Vec3 linear = linear_momentum(world), angular = angular_momentum(world);
    const double energy = kinetic_energy(world);
    const auto method = make_method("impulse", {{"step", 0.001}});
    double most = 0;
    for (int k = 1; k <= 200; ++k) {
      method->advance(world, k * 0.01);
      EXPECT_LT((linear_momentum(world) - linear).norm(), 1e-14);
      most = std::max(most, (angular_momentum(world) - angular).norm() / angular.norm());
      EXPECT_LT(kinetic_energy(world), energy * (1 + 1e-9));
    }
    EXPECT_FALSE(method->events().empty());
    EXPECT_LT(most, 1e-3);  // the step turns the sticks by 1e-2 rad; the error is of its square
  }
}

TEST(Impulse, TheMassOfTheConnectorTakesItsPartOfTheRebound) {
  // m_a is the reduced mass of both ends with the connector's end particles, 1/5 of it each.
  const double mass = 0.1, a = 0.12 + mass / 5, b = 0.3 + mass / 5;
  const double ends = a * b / (a + b);
  const Impact hit = impact(two_sticks(0.5, mass), {{"step", 1e-4}});
  const double ratio =
      -separation_speed(hit.after, hit.along) / separation_speed(hit.before, hit.along);
  EXPECT_NEAR(ratio, 0.5 * ends / (mass + ends), 3e-3);
}

TEST(Impulse, ThePrintedFormReboundsFullyBetweenEqualMasses) {
  World world;
  world.gravity = Vec3::Zero();
  Connector line = cord(1, 0, 3, Vec3::Zero(), Vec3(0.995, 0, 0));
  line.particle_mass = {0.5, 0, 0.5};
  line.velocity = {Vec3(-1, 0, 0), Vec3::Zero(), Vec3(1, 0, 0)};
  world.connectors = {line};
  for (const bool printed : {true, false}) {
    World run = world;
    make_method("impulse", {{"step", 0.001}, {"as_printed", printed}})->advance(run, 0.01);
    const double after = run.connectors[0].velocity[2].x() - run.connectors[0].velocity[0].x();
    EXPECT_NEAR(after, printed ? -2 : 0, 1e-12);
  }
}

TEST(Impulse, ThePrintedFormLetsAHandleSinkWhereRestitutionIsSmallerThanTheMassRatio) {
  // Each step gravity adds g dt to a hanging handle's speed and the impulse leaves the part
  // f = 1 - (1 + e) m_a / (m_c + m_a) of it: it settles at f/(1-f) g dt, downwards for f > 0,
  // which is e < m_c/m_a. Over a step it moves with the mean of its speeds.
  const double handle = 0.4, rope = 0.1, dt = 0.001;
  for (const double restitution : {0.0, 0.1, 0.2, 0.24}) {
    World world;
    Connector line = cord(1, rope, 2, Vec3::Zero(), Vec3(0, -1, 0));
    line.holds = {{0, fixed(Vec3::Zero())}};
    line.particle_mass[1] = handle;
    line.restitution = restitution;
    world.connectors = {line};
    finish(world);
    World corrected = world;
    make_method("impulse", {{"step", dt}, {"as_printed", true}})->advance(world, 2.0);
    const double left = 1 - (1 + restitution) * handle / (rope + handle);
    const double rate = left / (1 - left) * kGravity * dt;
    const double sunk = -1 - world.connectors[0].position[1].y();
    EXPECT_GT(left, 0);
    EXPECT_NEAR(sunk, rate * 2, 0.01 * rate * 2 + 1e-5);
    make_method("impulse", {{"step", dt}})->advance(corrected, 2.0);
    EXPECT_NEAR(corrected.connectors[0].position[1].y(), -1, 1e-12);
  }
}

}  // namespace
}  // namespace taut::impulse_impact_test
