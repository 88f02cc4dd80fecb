// Contact by the direct method: beads and ropes whose motion is known beforehand.
#include <gtest/gtest.h>

#include <numbers>

#include "contact_worlds.h"
#include "scenes/load/load_scene.h"
#include "sim/measure/measure.h"

namespace taut::contact_test {
namespace {

using namespace contact_worlds;
using worlds::kGravity;

constexpr double kRounding = 1e-12;

// Free fall, then a parabola with e times the speed.
TEST(Contact, ABeadBouncesAsNewtonSays) {
  const double lands = std::sqrt(2 / kGravity);
  for (const double e : {0.0, 0.5, 0.9, 1.0}) {
    Simulation simulation =
        by_direct(pair(Vec3(0, 1, 0), Vec3::Zero(), obstacle(plane_shape(), 0, e)));
    for (int frame = 1; frame <= 70; ++frame) {
      const double time = frame / 60.0, after = time - lands;
      simulation.advance_to(time);
      const double speed = after < 0 ? 0 : e * kGravity * lands;
      double height =
          after < 0 ? 1 - kGravity * time * time / 2 : speed * after - kGravity * after * after / 2;
      if (after > 0 && height < 0) {
        if (e > 0) break;  // it lands once more
        height = 0;
      }
      EXPECT_NEAR(simulation.world().connectors[0].position[0].y(), height, kRounding)
          << "restitution " << e << " at " << time;
    }
  }
}

// The bead bounces infinitely often until (1+e)/(1-e) fall times have passed, and lies still.
TEST(Contact, BouncesEnd) {
  constexpr double e = 0.5;
  const double lands = std::sqrt(2 / kGravity);
  Simulation simulation =
      by_direct(pair(Vec3(0, 1, 0), Vec3::Zero(), obstacle(plane_shape(), 0, e)));
  simulation.advance_to(lands * (1 + e) / (1 - e) + 0.02);
  EXPECT_LT(simulation.world().connectors[0].position[0].y(), 1e-5);  // a tenth of the tolerance
  EXPECT_LT(fastest(simulation.world()), kRounding);
}

// A bead that sticks creeps with 1e-14 of the speed gained in a step without, of 1/60 s at most.
constexpr double kCrept = 1e-14 * kGravity / 60;

// x = g t^2 (sin a - mu cos a)/2 where tan a > mu, else nothing.
TEST(Contact, ABeadOnAnInclineSlidesOrSticks) {
  const double angle = std::atan(0.5);
  for (const double mu : {0.0, 0.2, 0.4999999, 0.5000001, 1.5}) {
    Obstacle incline = obstacle(plane_shape(), mu);
    incline.place.rotation = Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
    Simulation simulation = by_direct(pair(Vec3::Zero(), Vec3::Zero(), incline));
    simulation.advance_to(1);
    const double down = kGravity * (std::sin(angle) - mu * std::cos(angle));
    EXPECT_NEAR(simulation.world().connectors[0].position[0].norm(), std::max(0.0, down / 2),
                kRounding)
        << mu;
    if (mu > 0.5) {
      EXPECT_LT(fastest(simulation.world()), kCrept);
    }
  }
}

// Pushed up an incline it stops after v^2/2a, and stays there by static friction alone.
TEST(Contact, ABeadStopsWhereItMust) {
  constexpr double speed = 2, kinetic = 0.3;
  const double angle = std::atan(0.5);
  const Vec3 up(std::cos(angle), std::sin(angle), 0);
  Obstacle incline = obstacle(plane_shape(), kinetic);
  incline.static_friction = 0.6;
  incline.place.rotation = Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
  Simulation simulation = by_direct(pair(Vec3::Zero(), speed * up, incline));
  simulation.advance_to(2);
  const double slowing = kGravity * (std::sin(angle) + kinetic * std::cos(angle));
  const double way = simulation.world().connectors[0].position[0].dot(up);
  EXPECT_NEAR(way, speed * speed / (2 * slowing),
              1e-4);  // the tolerance: its last step is too long
  EXPECT_LT(fastest(simulation.world()), kCrept);
}

// A belt takes it along: mu g t, as long as it is slower than the belt; then it sticks.
TEST(Contact, AMovingFloorCarriesABead) {
  constexpr double mu = 0.3;
  Obstacle floor = obstacle(plane_shape(), mu);
  floor.path = std::make_shared<const Path>(std::vector<PathKey>{
      {-5, Vec3(-5, 0, 0), Quat::Identity(), true}, {5, Vec3(5, 0, 0), Quat::Identity(), true}});
  ASSERT_GT(floor.frame(0.2).velocity.x(), 0.9);
  ASSERT_LT(std::abs(floor.frame(0.2).acceleration.x()), mu * kGravity);
  Simulation simulation = by_direct(pair(Vec3::Zero(), Vec3::Zero(), floor));
  simulation.advance_to(0.2);
  EXPECT_NEAR(simulation.world().connectors[0].velocity[0].x(), mu * kGravity * 0.2, kRounding);
  simulation.advance_to(1);
  const Vec3 there = simulation.world().connectors[0].position[0];
  EXPECT_NEAR(simulation.world().connectors[0].velocity[0].x(), floor.frame(1).velocity.x(),
              kRounding);
  simulation.advance_to(2);
  const double gone = simulation.world().connectors[0].position[0].x() - there.x();
  EXPECT_NEAR(gone, floor.frame(2).position.x() - floor.frame(1).position.x(), kRounding);
}

// Lifted, then left behind where the floor falls faster than it.
TEST(Contact, ARisingFloorLiftsABead) {
  Obstacle floor = obstacle(plane_shape());
  floor.path = std::make_shared<const Path>(std::vector<PathKey>{
      {0, Vec3::Zero(), Quat::Identity(), true}, {1, Vec3(0, 0.5, 0), Quat::Identity(), true}});
  Simulation simulation = by_direct(pair(Vec3::Zero(), Vec3::Zero(), floor));
  for (int frame = 1; frame <= 30; ++frame) {
    simulation.advance_to(frame / 60.0);
    EXPECT_NEAR(simulation.world().connectors[0].position[0].y(),
                floor.frame(frame / 60.0).position.y(), 1e-9);
  }
}

// At rest as it hangs, and as it lies: nothing moves at all.
TEST(Contact, AChainAtRestOnAFloorStaysThere) {
  for (const double mu : {0.0, 0.5}) {
    World world;
    Connector chain = straight_connector("chain", 1, 0.5, 41, Vec3(0, 0.5, 0), -Vec3::UnitY());
    for (std::size_t i = 20; i <= 40; ++i) {
      chain.position[i] = Vec3(0.025 * static_cast<double>(i - 20), 0, 0);
    }
    chain.holds = {{0, worlds::fixed_at(Vec3(0, 0.5, 0))}};
    world.connectors = {chain};
    world.obstacles = {obstacle(plane_shape(), mu)};
    finish(world);
    Simulation simulation = by_direct(world);
    simulation.advance_to(10);
    EXPECT_LT(fastest(simulation.world()), 1e-9);
    for (std::size_t i = 0; i < 41; ++i) {
      EXPECT_LT((simulation.world().connectors[0].position[i] - chain.position[i]).norm(), 1e-9);
    }
  }
}

// A few links may stand as an arch on beads that grip, and sway for ever: nothing damps them.
TEST(Contact, ARopeThatFallsComesToRest) {
  for (const double mu : {0.1, 0.4, 1.0}) {
    const World world = falling_rope(41, obstacle(plane_shape(), mu));
    Simulation simulation = by_direct(world);
    simulation.advance_to(10);
    EXPECT_LT(kinetic_energy(simulation.world()), 1e-3 * potential_energy(world)) << mu;
  }
}

// Roundings of places grow with a rope's length; where they were taken for errors, each step took a
// hundred systems.
TEST(Contact, ALongRopeLandsInFewSystems) {
  World world;
  Connector rope = straight_connector("rope", 200, 1, 2001, Vec3(0, 1.1e-3, 0), Vec3::UnitX());
  rope.radius = 1e-3;
  world.connectors = {rope};
  world.obstacles = {obstacle(plane_shape(), 0.5)};
  finish(world);
  Simulation simulation = by_direct(world, 1e-3);
  simulation.advance_to(0.1);
  const Counters& counters = simulation.method().counters();
  EXPECT_LE(counters.solves, 10 * counters.steps);   // a step and its halves have two stages each
  EXPECT_LE(penetration(simulation.world()), 2e-7);  // 1e-9 of its length
}

TEST(Contact, EnergyNeverRises) {
  for (const double mu : {0.0, 0.3, 1.0, 2.0}) {
    const World world = falling_rope(31, obstacle(plane_shape(), mu));
    constexpr double kTolerance = 1e-3;  // of a length of 1 m
    Simulation simulation = by_direct(world, kTolerance);
    const double scale = energy_scale(world), share = 0.02 * kTolerance;
    double before = kinetic_energy(world) + potential_energy(world);
    for (int frame = 1; frame <= 120; ++frame) {
      simulation.advance_to(frame / 60.0);
      const World& now = simulation.world();
      const double energy = kinetic_energy(now) + potential_energy(now);
      EXPECT_LE(energy, before + share * scale) << mu << " at " << now.time;
      before = energy;
      EXPECT_LE(penetration(now), 1e-9);
      EXPECT_LT(stretch_max(now), 1e-7);
    }
  }
}

// A floor without friction gives no momentum along itself.
TEST(Contact, AFloorWithoutFrictionKeepsTheMomentumAlongIt) {
  World world = falling_rope(21, obstacle(plane_shape()));
  for (Vec3& velocity : world.connectors[0].velocity) velocity = Vec3(0.7, 0, -0.3);
  const Vec3 before = linear_momentum(world);
  Simulation simulation = by_direct(world, 1e-3);
  simulation.advance_to(1.5);
  const Vec3 after = linear_momentum(simulation.world());
  EXPECT_NEAR(after.x(), before.x(), kRounding);
  EXPECT_NEAR(after.z(), before.z(), kRounding);
}

// A plate of a millimetre, at any speed and rate of frames.
TEST(Contact, NothingTunnels) {
  Obstacle plate = obstacle(box_shape(Vec3(1000, 0.001, 1000), 0.0005));
  for (const double speed : {3.0, 30.0, 300.0}) {
    for (const double fps : {1000.0, 60.0, 2.0}) {
      World world = falling_rope(11, plate);
      for (Vec3& velocity : world.connectors[0].velocity) velocity = Vec3(0, -speed, 0);
      Simulation simulation = by_direct(world, 1e-3);
      for (int frame = 1; frame <= 0.5 * fps; ++frame) {
        simulation.advance_to(frame / fps);
        for (const Vec3& at : simulation.world().connectors[0].position) {
          ASSERT_GT(at.y(), 0.005) << speed << " m/s at " << frame / fps;
        }
      }
    }
  }
}

// A rope that comes never near an obstacle moves as without: bit by bit.
TEST(Contact, NothingNearChangesNothing) {
  World world = worlds::chain(21, 0.5, worlds::from_down(60));
  Simulation alone = by_direct(world);
  Obstacle far = obstacle(sphere_shape(0.2));
  far.place.position = Vec3(3, 0, 0);
  world.obstacles = {far};
  world.topology = structure(world);
  Simulation with = by_direct(world);
  for (int frame = 1; frame <= 60; ++frame) {
    alone.advance_to(frame / 60.0);
    with.advance_to(frame / 60.0);
    ASSERT_EQ(alone.world().connectors[0].position, with.world().connectors[0].position) << frame;
    ASSERT_EQ(alone.world().connectors[0].velocity, with.world().connectors[0].velocity) << frame;
  }
}

// Links fall onto the plate of a scale one after the other: each step ends where the next one
// arrives, so that none is done again.
TEST(Contact, ArrivalsAreForetold) {
  const scenes::Scene scene =
      scenes::load_scene(TAUT_SOURCE_DIR "/scenes/contact/scale.toml", false);
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-3}}));
  simulation.advance_to(0.6);
  EXPECT_GT(simulation.method().counters().steps, 50u);
  EXPECT_LT(10 * simulation.method().counters().rejected, simulation.method().counters().steps);
}

}  // namespace
}  // namespace taut::contact_test
