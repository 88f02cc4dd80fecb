// The impulse method against what is known of free flight, impacts, pendulums and repositioning.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sim/measure.h"
#include "sim/simulation.h"

namespace taut {
namespace {

const double kGravity = 9.81;

Attachment fixed(const Vec3& point) {
  return {Attachment::Kind::fixed, point, nullptr, 0};
}
Attachment on_body(std::size_t body, const Vec3& point) {
  return {Attachment::Kind::body, point, nullptr, body};
}

Body stick(const Vec3& centre, const Vec3& velocity, const Vec3& spin = Vec3::Zero()) {
  Body body;
  body.name = "stick";
  body.mass_properties = solid_cylinder(0.12, 0.3, 0.028);
  body.position = centre;
  body.velocity = velocity;
  body.spin = spin;
  return body;
}

/// A cord of which only the ends matter at first: its particles lie between `from` and `to`.
Connector cord(double length, double mass, std::size_t particles, const Vec3& from,
               const Vec3& to) {
  Connector made = straight_connector("cord", length, mass, particles, from, Vec3::UnitX());
  for (std::size_t i = 0; i < particles; ++i) {
    made.position[i] =
        from + static_cast<double>(i) / static_cast<double>(particles - 1) * (to - from);
  }
  return made;
}

/// A particle of 0.5 kg on a cord of 1 m from the origin, which has no mass, no other particle.
World pendulum(const Vec3& place) {
  World world;
  Connector line = cord(1, 0, 2, Vec3::Zero(), place);
  line.holds = {{0, fixed(Vec3::Zero())}};
  line.particle_mass[1] = 0.5;
  world.connectors = {line};
  finish(world);
  return world;
}

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

/// What a cord does to the ends that it stops: the relative velocity along it before and after,
/// and the kinetic energy lost.
struct Impact {
  World before, after;
  Vec3 along;  // from the first end to the last, when the cord went taut
  double lost = 0;
};

Vec3 end_velocity(const World& world, const Hold& hold) {
  return hold_motion(world, hold.to, world.time).velocity;
}

double parting(const World& world, const Vec3& along) {
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

/// The mass with which two ends resist parting along n: 1 / sum of n.(1/m + (I^-1 (r x n)) x r).
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

World stick_on_a_fixed_cord(double elasticity) {
  World world;
  world.bodies = {stick(Vec3(0.05, -0.1, 0.02), Vec3(0.4, -2, 0.3), Vec3(3, 2, -5))};
  Connector line = cord(0.2, 0, 5, Vec3(0, 0.15, 0), world.bodies[0].point(Vec3(0, 0.15, 0.01)));
  line.holds = {{0, fixed(Vec3(0, 0.15, 0))}, {4, on_body(0, Vec3(0, 0.15, 0.01))}};
  line.elasticity = elasticity;
  world.connectors = {line};
  return world;
}

World two_sticks(double elasticity, double cord_mass = 0) {
  World world;
  world.bodies = {stick(Vec3(0, 0, 0), Vec3(0.2, 1.5, 0), Vec3(1, 2, 3)),
                  stick(Vec3(0.05, -0.45, 0), Vec3(-0.1, -1, 0.4), Vec3(-2, 1, 4))};
  world.bodies[1].mass_properties = solid_cylinder(0.3, 0.3, 0.03);
  Connector line = cord(0.2, cord_mass, 5, world.bodies[0].point(Vec3(0, -0.15, 0)),
                        world.bodies[1].point(Vec3(0, 0.15, 0)));
  line.holds = {{0, on_body(0, Vec3(0, -0.15, 0))}, {4, on_body(1, Vec3(0, 0.15, 0))}};
  line.elasticity = elasticity;
  world.connectors = {line};
  return world;
}

TEST(Impulse, AGoingTautReversesThePartingByTheElasticity) {
  for (const double elasticity : {0.0, 0.3, 1.0}) {
    for (const World& world : {stick_on_a_fixed_cord(elasticity), two_sticks(elasticity)}) {
      const Impact hit = impact(world, {{"step", 1e-4}});
      const double before = parting(hit.before, hit.along), after = parting(hit.after, hit.along);
      ASSERT_GT(before, 0.5);
      // The bodies turn by up to spin * step = 6e-4 rad within the step of the impact.
      EXPECT_NEAR(after, -elasticity * before, 2e-3 * before);
      const double loss =
          reduced_mass(hit.before, hit.along) * before * before * (1 - elasticity * elasticity) / 2;
      EXPECT_NEAR(hit.lost, loss, 3e-3 * kinetic_energy(hit.before));
    }
  }
}

TEST(Impulse, TwoFreeBodiesKeepTheirMomentum) {
  for (const double elasticity : {0.0, 0.6}) {
    World world = two_sticks(elasticity);
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
  const double ratio = -parting(hit.after, hit.along) / parting(hit.before, hit.along);
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

TEST(Impulse, ThePrintedFormLetsAHandleSinkWhereElasticityIsSmallerThanTheMassRatio) {
  // Each step gravity adds g dt to a hanging handle's speed and the impulse leaves the part
  // f = 1 - (1 + e) m_a / (m_c + m_a) of it: it settles at f/(1-f) g dt, downwards for f > 0,
  // which is e < m_c/m_a. Over a step it moves with the mean of its speeds.
  const double handle = 0.4, rope = 0.1, dt = 0.001;
  for (const double elasticity : {0.0, 0.1, 0.2, 0.24}) {
    World world;
    Connector line = cord(1, rope, 2, Vec3::Zero(), Vec3(0, -1, 0));
    line.holds = {{0, fixed(Vec3::Zero())}};
    line.particle_mass[1] = handle;
    line.elasticity = elasticity;
    world.connectors = {line};
    finish(world);
    World corrected = world;
    make_method("impulse", {{"step", dt}, {"as_printed", true}})->advance(world, 2.0);
    const double left = 1 - (1 + elasticity) * handle / (rope + handle);
    const double rate = left / (1 - left) * kGravity * dt;
    const double sunk = -1 - world.connectors[0].position[1].y();
    EXPECT_GT(left, 0);
    EXPECT_NEAR(sunk, rate * 2, 0.01 * rate * 2 + 1e-5);
    make_method("impulse", {{"step", dt}})->advance(corrected, 2.0);
    EXPECT_NEAR(corrected.connectors[0].position[1].y(), -1, 1e-12);
  }
}

TEST(Impulse, NeighboursAreMovedByTheOthersPartOfTheirMass) {
  // A link of 1 m that is 1.2 m long, and one that is right once its neighbour has been moved.
  World world;
  world.gravity = Vec3::Zero();
  Connector line = straight_connector("cord", 2, 1, 3, Vec3::Zero(), Vec3::UnitX());
  line.particle_mass = {0.2, 0.3, 0.5};
  const double back = 0.2 * 0.2 / (0.2 + 0.3);  // m_j/(m_i+m_j) (|p_j-p_i| - l), from particle 1
  line.position = {Vec3::Zero(), Vec3(1.2, 0, 0), Vec3(1.2 - back, 1, 0)};
  line.mass = 0.6;  // a share of 0.2: the others are its particles, only heavier
  world.connectors = {line};
  World run = world;
  run.connectors[0].mass = 1.5;  // a share of 0.5: no end carries more
  make_method("impulse", {{"step", 0.001}})->advance(run, 0.001);
  const auto& moved = run.connectors[0];
  EXPECT_LT((moved.position[0] - Vec3(0.2 - back, 0, 0)).norm(), 1e-12);
  EXPECT_LT((moved.position[1] - Vec3(1.2 - back, 0, 0)).norm(), 1e-12);
  EXPECT_LT((moved.position[2] - world.connectors[0].position[2]).norm(), 1e-12);
  // Velocities from positions.
  EXPECT_LT((moved.velocity[1] - Vec3(-back / 0.001, 0, 0)).norm(), 1e-9);
  // Within h nothing moves: a link that is 0.15 m too short.
  World left = world;
  left.connectors[0].position[1] = Vec3(0.85, 0, 0);
  left.connectors[0].position[2] = Vec3(0.85, 1, 0);
  const std::vector<Vec3> before = left.connectors[0].position;
  make_method("impulse", {{"step", 0.001}, {"h", 0.16}})->advance(left, 0.001);
  EXPECT_EQ(left.connectors[0].position, before);
  make_method("impulse", {{"step", 0.001}, {"h", 0.14}})->advance(left, 0.002);
  EXPECT_NE(left.connectors[0].position, before);
}

TEST(Impulse, LimitsOfCompressionAndStretchAreSeparate) {
  World world;
  world.gravity = Vec3::Zero();
  Connector line = straight_connector("cord", 3, 0.3, 4, Vec3::Zero(), Vec3::UnitX());
  line.holds = {{0, fixed(Vec3::Zero())}, {3, fixed(Vec3(1.2, 0, 0))}};
  line.position = {Vec3::Zero(), Vec3(0.9, 0, 0), Vec3(0.9, 1.08, 0), Vec3(1.2, 0, 0)};
  world.connectors = {line};
  World run = world;
  make_method("impulse", {{"step", 0.001}, {"l_c", 0.9}, {"l_t", 1.2}})->advance(run, 0.001);
  EXPECT_EQ(run.connectors[0].position, world.connectors[0].position);
  make_method("impulse", {{"step", 0.001}})->advance(run, 0.002);
  EXPECT_GT((run.connectors[0].position[1] - world.connectors[0].position[1]).norm(), 0.01);
}

TEST(Impulse, ParticlesStayInReachOfBothEnds) {
  World world;
  world.bodies = {stick(Vec3(1, -0.15, 0), Vec3::Zero())};
  Connector line = straight_connector("cord", 1, 0.1, 11, Vec3::Zero(), Vec3::UnitX());
  line.holds = {{0, fixed(Vec3::Zero())}, {10, on_body(0, Vec3(0, 0.15, 0))}};
  world.connectors = {line};
  finish(world);
  const auto method = make_method("impulse", {{"step", 0.001}});
  for (int k = 1; k <= 300; ++k) {
    method->advance(world, k * 0.01);
    const auto& p = world.connectors[0].position;
    ASSERT_LT((p[10] - p[0]).norm(), 1 + 1e-9);  // the end body does not stretch the cord
    for (std::size_t i = 1; i < 10; ++i) {
      // The last clamp is to the last end; it may undo the first by what the taut span is off.
      EXPECT_LT((p[i] - p[10]).norm(), 0.1 * static_cast<double>(10 - i) + 1e-12);
    }
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
  world.connectors[0].elasticity = 0.5;
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
  // It comes to rest on the cord instead of trembling for ever.
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
}  // namespace taut
