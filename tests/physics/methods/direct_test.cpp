// The direct method against known answers.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/measure/measure.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"
#include "sim/run/trajectory.h"
#include "tests/physics/worlds.h"

namespace taut::direct_test {
namespace {

constexpr double kGravity = 9.81;

Settings tolerance(double metres) {
  return {{"tolerance", metres}};
}

/// n particles hanging from a fixed point, which is one more particle; all weigh the same.
World chain_of(std::size_t n, double length, double mass, const Vec3& direction) {
  World world;
  Connector chain = straight_connector("chain", length, mass, n + 1, Vec3::Zero(), direction);
  chain.holds.push_back({0, {}});
  world.connectors.push_back(chain);
  finish(world);
  return world;
}

Attachment on_body(std::size_t body, const Vec3& point) {
  Attachment to;
  to.kind = Attachment::Kind::body;
  to.point = point;
  to.body = body;
  return to;
}

// The modes of a hanging chain of n equal beads: w^2 l / g is a zero of the Laguerre polynomial
// L_n, and the beads' amplitudes, from the fixed end, are L_k at it in reverse order.
double laguerre(std::size_t n, double x) {
  double before = 1, now = 1 - x;
  if (n == 0) return before;
  for (std::size_t k = 1; k < n; ++k) {
    const double m = static_cast<double>(k);
    const double next = ((2 * m + 1 - x) * now - m * before) / (m + 1);
    before = now;
    now = next;
  }
  return now;
}

TEST(Direct, SmallSwingsKeepTheFrequenciesOfTheLaguerreZeros) {
  constexpr std::size_t n = 10;
  constexpr double length = 1;
  for (const double ratio : {1.17385464, 2.70084163, 4.25246152}) {
    const double w = ratio * std::sqrt(kGravity / length);
    const double zero = w * w * (length / n) / kGravity;
    World world = chain_of(n, length, 0.1, -Vec3::UnitY());
    constexpr double amplitude = 1e-6;  // m; the period's change is of its square
    Connector& chain = world.connectors[0];
    for (std::size_t k = 1; k <= n; ++k) {
      chain.position[k].x() = amplitude * laguerre(n - k, zero);
    }
    const Vec3 start = chain.position[n];
    Simulation simulation(world, make_method("direct", tolerance(5e-12)));
    simulation.advance_to(2 * std::numbers::pi / w);
    const Connector& after = simulation.world().connectors[0];
    EXPECT_NEAR(after.position[n].x(), start.x(), 1e-5 * amplitude) << ratio;
    simulation.advance_to(2.5 * 2 * std::numbers::pi / w);
    EXPECT_NEAR(simulation.world().connectors[0].position[n].x(), -start.x(), 1e-5 * amplitude);
  }
}

TEST(Direct, ACompoundPendulumSwingsByItsInertia) {
  World world;
  Body stick;
  stick.name = "stick";
  stick.mass_properties = solid_box(0.3, Vec3(0.02, 0.4, 0.05));
  stick.position = Vec3(0, -1.2, 0);
  world.bodies.push_back(stick);
  // A link of next to nothing, so that the box swings as one with it from the point above its end.
  Connector link = straight_connector("link", 1.0, 1e-9, 2, Vec3::Zero(), -Vec3::UnitY());
  link.holds = {{0, {}}, {1, on_body(0, Vec3(0, 0.2, 0))}};
  world.connectors.push_back(link);
  finish(world);

  // Two angles, a link of 1 m and the box: small swings of the lower mode, from the 2x2 problem
  // det(K - w^2 M) = 0 with M = m [1, a; a, a^2 + I/m], K = m g diag(1, a).
  const double a = 0.2, i = (0.4 * 0.4 + 0.02 * 0.02) / 12;
  const double c2 = i, c1 = -kGravity * (a + a * a + i), c0 = kGravity * kGravity * a;
  const double w2 = (-c1 - std::sqrt(c1 * c1 - 4 * c2 * c0)) / (2 * c2);
  const double tilt = 1e-6, slope = (kGravity - w2) / (w2 * a);
  World start = world;
  start.connectors[0].position[1] = Vec3(tilt, -1, 0);
  start.bodies[0].rotation = Quat(Eigen::AngleAxisd(slope * tilt, Vec3::UnitZ()));
  start.bodies[0].position =
      start.connectors[0].position[1] - start.bodies[0].rotation * Vec3(0, a, 0);
  Simulation simulation(start, make_method("direct", tolerance(1e-11)));
  simulation.advance_to(2 * std::numbers::pi / std::sqrt(w2));
  EXPECT_NEAR(simulation.world().connectors[0].position[1].x(), tilt, 1e-5 * tilt);
}

/// A box and a ball joined by a chain, thrown spinning.
World thrown() {
  World world;
  Body box, ball;
  box.name = "box";
  box.mass_properties = solid_box(0.4, Vec3(0.1, 0.2, 0.3));
  box.position = Vec3(0, 0, 0);
  box.velocity = Vec3(1, 4, 0.5);
  box.spin = Vec3(3, 1, 7);
  ball.name = "ball";
  ball.mass_properties = solid_sphere(0.2, 0.1);
  ball.position = Vec3(0.05 + 0.5 + 0.05, 0.1, 0);
  ball.velocity = Vec3(1, 3, -2);
  ball.spin = Vec3(0, 5, 1);
  world.bodies = {box, ball};
  Connector chain = straight_connector("chain", 0.5, 0.05, 11, Vec3(0.05, 0.1, 0), Vec3::UnitX());
  chain.holds = {{0, on_body(0, Vec3(0.05, 0.1, 0))}, {10, on_body(1, Vec3(-0.05, 0, 0))}};
  world.connectors.push_back(chain);
  finish(world);
  // Velocities that keep every length: those of the ends, and turning links between them.
  Connector& c = world.connectors[0];
  const Vec3 from = c.velocity[0], to = c.velocity[10];
  Vec3 across = to - from;
  across.x() = 0;
  world.bodies[1].velocity.x() += from.x() - to.x();
  for (std::size_t k = 1; k < 10; ++k) {
    c.velocity[k] = from + static_cast<double>(k) / 10 * across;
  }
  place_held(world, 0);
  return world;
}

TEST(Direct, AFreeFlightConservesBothMomentaToRounding) {
  World world = thrown();
  const Vec3 linear = linear_momentum(world);
  Simulation simulation(world, make_method("direct", tolerance(1e-4)));
  const double mass = linear_momentum(world).norm() / 1;
  for (const double time : {0.1, 0.35, 1.0}) {
    simulation.advance_to(time);
    const World& now = simulation.world();
    const double weight = 0.65 * kGravity;
    const Vec3 expected = linear - Vec3(0, weight * time, 0);
    EXPECT_LT((linear_momentum(now) - expected).norm() / mass, 1e-14);
    // About the centre of mass: L - M x v, and L about the origin gains what gravity gives.
    const auto spin_part = [](const World& w) {
      Vec3 centre = Vec3::Zero();
      double total = 0;
      for (const Body& body : w.bodies) {
        centre += body.mass_properties.mass * body.position;
        total += body.mass_properties.mass;
      }
      const Connector& c = w.connectors[0];
      for (std::size_t k = 1; k < 10; ++k) {
        centre += c.particle_mass[k] * c.position[k];
        total += c.particle_mass[k];
      }
      return Vec3(angular_momentum(w) - (centre / total).cross(linear_momentum(w)));
    };
    EXPECT_LT((spin_part(now) - spin_part(world)).norm() / spin_part(world).norm(), 1e-13);
    EXPECT_LT(stretch_max(now), 1e-13);
    EXPECT_NEAR(energy(now), energy(world), 1e-3 * std::abs(energy(world)));
  }
}

TEST(Direct, EnergyIsKeptWithinTheTolerance) {
  World world = chain_of(20, 0.2, 0.05, Vec3::UnitX());
  world.connectors[0].particle_mass[20] += 0.2;
  const double before = energy(world);
  for (const double metres : {1e-3, 1e-5, 1e-7}) {
    Simulation simulation(world, make_method("direct", tolerance(metres)));
    simulation.advance_to(1);
    // An error of position is worth weight times height.
    EXPECT_LT(std::abs(energy(simulation.world()) - before), 0.25 * kGravity * 3 * metres);
    EXPECT_LT(stretch_max(simulation.world()), 1e-13);
  }
}

// A heavy load on a light chain, let go from the side: no tolerance is dearer than half the length.
TEST(Direct, ALooserToleranceCostsNoMore) {
  constexpr double length = 0.2;
  World world = chain_of(50, length, 0.05, Vec3::UnitX());
  world.connectors[0].particle_mass.back() += 5;
  finish(world);
  const auto solves = [&](double metres) {
    Simulation simulation(world, make_method("direct", tolerance(metres)));
    for (int frame = 1; frame <= 60; ++frame) simulation.advance_to(frame / 60.0);
    return simulation.method().counters().solves;
  };
  const auto half = solves(length / 2);
  for (const double metres : {0.14, 0.3, 1.0, 10.0}) EXPECT_EQ(solves(metres), half) << metres;
}

TEST(Direct, TimeRunsBackToTheStartAtAFixedStep) {
  World world = chain_of(20, 0.2, 0.05, Vec3::UnitX());
  world.connectors[0].particle_mass[20] += 0.2;
  Simulation there(world, make_method("direct", {{"step", 1.0 / 2000}}));
  there.advance_to(0.4);
  World turned = there.world();
  for (Vec3& velocity : turned.connectors[0].velocity) velocity = -velocity;
  Simulation back(turned, make_method("direct", {{"step", 1.0 / 2000}}));
  back.advance_to(0.8);
  for (std::size_t k = 0; k <= 20; ++k) {
    EXPECT_LT((back.world().connectors[0].position[k] - world.connectors[0].position[k]).norm(),
              1e-9);
  }
}

TEST(Direct, APinnedChainKeepsItsPins) {
  World world;
  Connector chain = straight_connector("chain", 1, 0.1, 21, Vec3::Zero(), Vec3::UnitX());
  const std::vector<Vec3> left =
      hanging_points(chain, Vec3::Zero(), Vec3(0.7, 0.1, 0), world.gravity);
  chain.position = left;
  Attachment end;
  end.point = Vec3(0.7, 0.1, 0);
  chain.holds = {{0, {}}, {20, end}};
  world.connectors.push_back(chain);
  finish(world);
  Simulation rest(world, make_method("direct", {}));
  rest.advance_to(0.5);
  // The catenary is in equilibrium.
  for (std::size_t k = 0; k <= 20; ++k) {
    EXPECT_LT((rest.world().connectors[0].position[k] - left[k]).norm(), 1e-6);
  }

  // A pin in the middle takes hold and lets go again.
  World pinned = rest.world();
  Attachment pin;
  pin.point = pinned.connectors[0].position[7];
  pinned.connectors[0].holds.insert(pinned.connectors[0].holds.begin() + 1, {7, pin});
  pinned.topology += 1;
  pinned.connectors[0].velocity[14] = Vec3(0, 0, 0.01);
  Simulation held(pinned, make_method("direct", {}));
  held.advance_to(1);
  EXPECT_EQ(held.world().connectors[0].position[7], pin.point);
  EXPECT_LT(stretch_max(held.world()), 1e-12);
}

TEST(Direct, ABarOnTwoCordsKeepsItsEnergyAndItsHolds) {
  // The bar, heavier on one side, couples the links of both cords and closes a loop.
  World world;
  Body bar;
  bar.name = "bar";
  bar.mass_properties =
      with_point_mass(solid_box(0.5, Vec3(0.6, 0.02, 0.02)), 0.5, Vec3(0.2, 0, 0));
  bar.position = bar.mass_properties.centre + Vec3(0, -1, 0);
  world.bodies.push_back(bar);
  for (const double x : {-0.3, 0.3}) {
    Connector cord = straight_connector("cord", 1, 0.02, 11, Vec3(x, 0, 0), -Vec3::UnitY());
    Attachment top;
    top.point = Vec3(x, 0, 0);
    cord.holds = {{0, top}, {10, on_body(0, Vec3(x, 0, 0))}};
    world.connectors.push_back(cord);
  }
  finish(world);
  world.bodies[0].velocity = Vec3(0, 0, 0.5);
  for (Connector& cord : world.connectors) {
    for (std::size_t k = 0; k <= 10; ++k)
      cord.velocity[k] = Vec3(0, 0, 0.05 * static_cast<double>(k));
  }
  const double before = energy(world);
  Simulation simulation(world, make_method("direct", tolerance(1e-6)));
  simulation.advance_to(1);
  const World& now = simulation.world();
  EXPECT_NEAR(energy(now), before, 1e-7 * std::abs(before));
  EXPECT_LT(stretch_max(now), 1e-12);
  for (const Connector& cord : now.connectors) {
    const Vec3 held = now.bodies[0].point(cord.holds[1].to.point);
    EXPECT_LT((cord.position[10] - held).norm(), 1e-12);
  }
}

// A body that nothing holds flies by itself.
TEST(Direct, ABodyWithoutAConnectorFallsAndSpins) {
  World world;
  world.bodies = {worlds::box("box")};
  finish(world);
  const Vec3 momentum = world.bodies[0].world_inertia() * world.bodies[0].spin;
  make_method("direct", {{"tolerance", 1e-8}})->advance(world, 0.5);
  const Body& box = world.bodies[0];
  EXPECT_NEAR(box.position.y(), -worlds::kGravity * 0.125, 1e-9);
  EXPECT_LT((box.world_inertia() * box.spin - momentum).norm(), 1e-7 * momentum.norm());
}

}  // namespace
}  // namespace taut::direct_test
