// The impulse method against what is known of free flight, pendulums, joints, pins and events.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "tests/physics/methods/impulse_worlds.h"

namespace taut::impulse_test {
namespace {

TEST(Impulse, SlackBodiesFallFreelyToRounding) {
  World world;
  world.bodies = {stick(Vec3(0.1, 1, 0), Vec3(0.3, 2, -0.1), Vec3(4, 1, 2))};
  Connector line = cord(5, 0.05, 11, Vec3::Zero(), Vec3(0.1, 1.15, 0));
  line.holds = {{0, fixed(Vec3::Zero())}, {10, on_body(0, Vec3(0, 0.15, 0))}};
  world.connectors = {line};
  finish(world);
  const Vec3 start = world.bodies[0].position, velocity = world.bodies[0].velocity;
  const auto method = make_method("impulse", {{"step", 0.001}});
  for (int k = 1; k <= 60; ++k) {
    const double t = k * 0.01;
    method->advance(world, t);
    const Vec3 expected = start + velocity * t + Vec3(0, -kGravity, 0) * t * t / 2;
    EXPECT_LT((world.bodies[0].position - expected).norm(), 1e-13) << t;
    EXPECT_LT((world.bodies[0].velocity - velocity - Vec3(0, -kGravity, 0) * t).norm(), 1e-13);
  }
}

/// Time of the pendulum's first passage through the lowest point: a quarter of its period.
double quarter_period(World world, double step) {
  const auto method = make_method("impulse", {{"step", step}});
  for (int k = 1;; ++k) {
    const double before = world.connectors[0].position.back().x();
    method->advance(world, k * step);
    const double after = world.connectors[0].position.back().x();
    if (after <= 0) return (k - after / (after - before)) * step;
    if (k > 1e6) return 0;
  }
}

TEST(Impulse, APendulumOfTwoParticlesHasItsPeriodAndKeepsItsEnergy) {
  const struct {
    double degrees, period;
  } known[] = {{60, 1.0731820072}, {90, 1.1803405990}, {120, 1.3728805006}, {170, 2.4393627197}};
  for (const auto& [degrees, period] : known) {
    const double angle = degrees * M_PI / 180;
    const World start = pendulum(Vec3(std::sin(angle), -std::cos(angle), 0));
    const double expected = period * 2 * M_PI / std::sqrt(kGravity) / 4;
    const double coarse = quarter_period(start, 0.002) / expected - 1;
    const double fine = quarter_period(start, 0.001) / expected - 1;
    EXPECT_LT(std::abs(fine), 2e-5) << degrees;
    EXPECT_NEAR(coarse / fine, 4, 1.5) << degrees;  // second order
    World world = start;
    const double energy = kinetic_energy(world) + potential_energy(world);
    make_method("impulse", {{"step", 0.001}})->advance(world, 10);
    EXPECT_NEAR(kinetic_energy(world) + potential_energy(world), energy, 1e-4 * 0.5 * kGravity);
  }
}

TEST(Impulse, AJointHoldsInEveryDirection) {
  // A stick that swings from its end, from horizontal: at the bottom its energy gives its spin.
  World world;
  world.bodies = {stick(Vec3(0.15, 0, 0), Vec3::Zero())};
  world.bodies[0].rotation = Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()));
  Connector joint = straight_connector("joint", 0, 0, 2, Vec3::Zero(), Vec3::Zero());
  joint.holds = {{0, fixed(Vec3::Zero())}, {1, on_body(0, Vec3(0, 0.15, 0))}};
  world.connectors = {joint};
  finish(world);
  const double about_end = world.bodies[0].mass_properties.inertia(0, 0) + 0.12 * 0.15 * 0.15;
  const auto method = make_method("impulse", {{"step", 0.001}});
  double most = 0;
  for (int k = 1; k <= 5000; ++k) {
    method->advance(world, k * 0.001);
    const Body& body = world.bodies[0];
    ASSERT_LT(body.point(Vec3(0, 0.15, 0)).norm(), 1e-9);
    const double spin =
        std::sqrt(2 * 0.12 * kGravity * std::max(0.0, -body.position.y()) / about_end);
    most = std::max(most, std::abs(body.spin.norm() - spin));
  }
  EXPECT_LT(most, 1e-2);  // of 10 rad/s
}

TEST(Impulse, EventsTellWhenAndHowMuch) {
  // A particle falls from 0.4 m below its fixed point, on a cord of 1 m, and rebounds.
  World world = pendulum(Vec3(0, -0.4, 0));
  world.connectors[0] = cord(1, 0, 5, Vec3::Zero(), Vec3(0, -0.4, 0));
  world.connectors[0].holds = {{0, fixed(Vec3::Zero())}};
  world.connectors[0].particle_mass[4] = 0.5;
  world.connectors[0].restitution = 0.5;
  finish(world);
  const auto method = make_method("impulse", {{"step", 0.0005}});
  method->advance(world, 1.0);
  const double first = std::sqrt(2 * 0.6 / kGravity), speed = kGravity * first;
  const auto& events = method->events();
  ASSERT_GE(events.size(), 6u);
  const Event::Kind order[] = {Event::Kind::taut, Event::Kind::impulse, Event::Kind::slack};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(events[i].kind, order[i % 3]) << i;
  // Going taut is placed within the step by the mean speed in it: off by g dt^2 / 8 of way.
  EXPECT_NEAR(events[0].time, first, kGravity * 0.0005 * 0.0005 / speed);
  EXPECT_NEAR(events[1].size, 0.5 * speed * 1.5, 0.5 * kGravity * 0.0005 * 1.5);
  EXPECT_NEAR(events[2].time, first, 0.0011);
  // Up and down again at half the speed, by that time's parabola.
  EXPECT_NEAR(events[3].time, first + speed / kGravity, 0.001);
  EXPECT_NEAR(events[4].size, 0.5 * speed * 0.5 * 1.5, 0.5 * kGravity * 0.002);
  double last = 0;
  for (const Event& event : events) {
    EXPECT_GE(event.time, last - 0.0005);
    last = event.time;
  }
  // The particle comes to rest on the cord instead of trembling for ever.
  const std::size_t count = events.size();
  method->advance(world, 4.0);
  const std::size_t settled = method->events().size();
  EXPECT_LT(settled - count, 60u);
  method->advance(world, 6.0);
  EXPECT_EQ(method->events().size(), settled);
}

TEST(Impulse, APinDividesAConnectorIntoTwo) {
  // Held at its middle, the lower half swings like a pendulum of half the length.
  World world = pendulum(Vec3(0, -1, 0));
  Connector line = straight_connector("cord", 1, 0, 11, Vec3::Zero(), Vec3(0, -1, 0));
  line.holds = {{0, fixed(Vec3::Zero())}, {5, fixed(Vec3(0, -0.5, 0))}};
  line.particle_mass[10] = 0.5;
  for (std::size_t i = 6; i < 11; ++i) {
    line.position[i] = Vec3(0, -0.5, 0) + 0.1 * double(i - 5) * Vec3(std::sqrt(0.75), -0.5, 0);
  }
  world.connectors = {line};
  finish(world);
  EXPECT_NEAR(quarter_period(world, 0.001), 1.0731820072 * 2 * M_PI * std::sqrt(0.5 / kGravity) / 4,
              2e-5);
}

TEST(Impulse, OneBodyCarriesSeveralConnectors) {
  // A stick hangs level from two cords, one at each end, after a drop.
  World world;
  world.bodies = {stick(Vec3(0, -0.1, 0), Vec3::Zero())};
  world.bodies[0].rotation = Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()));
  for (const double side : {1.0, -1.0}) {
    const Vec3 top(-0.15 * side, 0, 0);
    Connector line = cord(0.2, 0.01, 6, top, top - Vec3(0, 0.1, 0));
    line.holds = {{0, fixed(top)}, {5, on_body(0, Vec3(0, 0.15 * side, 0))}};
    world.connectors.push_back(line);
  }
  finish(world);
  const auto method = make_method("impulse", {{"step", 0.001}});
  for (int k = 1; k <= 200; ++k) {
    method->advance(world, k * 0.01);
    for (const Connector& line : world.connectors) {
      EXPECT_LT((line.position[5] - line.position[0]).norm(), 0.2 * (1 + 1e-3));
    }
  }
  EXPECT_NEAR(world.bodies[0].position.y(), -0.2, 1e-3);
  EXPECT_LT(world.bodies[0].spin.norm(), 0.05);
}

TEST(Impulse, TheSameBitsTwiceAndAtAnyFrameRate) {
  World world = two_sticks(0.3, 0.02);
  finish(world);
  std::uint64_t hashes[3] = {};
  const int fps[] = {100, 25, 100};
  for (int i = 0; i < 3; ++i) {
    Simulation simulation(world, make_method("impulse", {{"step", 0.001}}));
    for (int k = 1; k <= 3 * fps[i]; ++k) simulation.advance_to(k / static_cast<double>(fps[i]));
    hashes[i] = state_hash(simulation.world());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(Impulse, SaysWhereItDiverged) {
  World world = pendulum(Vec3(0, -1, 0));
  world.connectors[0].velocity[1].x() = std::numeric_limits<double>::quiet_NaN();
  try {
    make_method("impulse", {})->advance(world, 0.01);
    FAIL();
  } catch (const Diverged& diverged) {
    EXPECT_EQ(diverged.method, "impulse");
    EXPECT_EQ(diverged.time, 0.001);
    EXPECT_EQ(diverged.step, 1u);
    EXPECT_EQ(diverged.connector, "cord");
    EXPECT_EQ(diverged.link, 0u);
  }
}

}  // namespace
}  // namespace taut::impulse_test
