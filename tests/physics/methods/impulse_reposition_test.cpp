// Where repositioning puts particles: shares of mass, limits, and the reach of both ends.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "tests/physics/methods/impulse_worlds.h"

namespace taut::impulse_reposition_test {
namespace {

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

}  // namespace
}  // namespace taut::impulse_reposition_test
