// Obstacles that ignore some things: those pass, others are stopped.
#include <gtest/gtest.h>

#include <string>

#include "contact_worlds.h"

namespace taut::ignored_test {
namespace {

using namespace contact_worlds;

/// Two ropes that fall side by side, and a stick.
World falling() {
  World world;
  for (const double z : {0.0, 1.0}) {
    Connector rope = straight_connector("rope", 0.4, 0.1, 5, Vec3(0, 0.2, z), Vec3(1, 0.3, 0));
    rope.radius = 0.01;
    world.connectors.push_back(rope);
  }
  Body stick;
  stick.mass_properties = solid_cylinder(0.2, 0.3, 0.02);
  stick.position = Vec3(0, 0.3, 2);
  stick.capsule = {.radius = 0.01, .from = Vec3(0, -0.14, 0), .to = Vec3(0, 0.14, 0)};
  world.bodies = {stick};
  return world;
}

class Ignored : public testing::TestWithParam<const char*> {
 protected:
  Simulation run(World world) const {
    finish(world);
    const bool by_steps = method_ == "xpbd" || method_ == "springs";
    Simulation simulation(
        world, make_method(method_, by_steps ? Settings{{"step", 1.0 / 1920}} : Settings{}));
    simulation.advance_to(0.5);
    return simulation;
  }
  const std::string method_ = GetParam();
};

TEST_P(Ignored, PassAsIfItWereNotThere) {
  World world = falling();
  const World freely = run(world).world();
  world.connectors[1].category = 2;
  for (Body& body : world.bodies) body.capsule.category = 4;
  world.obstacles = {obstacle(plane_shape(), 0.3)};
  world.obstacles[0].ignores = 2 | 4;
  const World now = run(world).world();
  EXPECT_GE(now.connectors[0].position[0].y(), 0.01 - 1e-9);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_LT((now.connectors[1].position[i] - freely.connectors[1].position[i]).norm(), 1e-9);
    EXPECT_LT(now.connectors[1].position[i].y(), -0.5);
  }
  for (std::size_t b = 0; b < now.bodies.size(); ++b) {
    EXPECT_LT((now.bodies[b].position - freely.bodies[b].position).norm(), 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, Ignored, testing::Values("truth", "direct", "xpbd", "springs"));

TEST(IgnoredParts, PassAsTheWholeDid) {
  World world = falling();
  world.bodies.clear();
  world.connectors.erase(world.connectors.begin());
  world.connectors[0].category = 1;
  world.obstacles = {obstacle(plane_shape())};
  world.obstacles[0].ignores = 1;
  finish(world);
  Simulation simulation(world, make_method("direct", {}));
  simulation.advance_to(0.1);
  ASSERT_EQ(simulation.interventions().cut(simulation.world(), 0, 0.25).outcome, Outcome::done);
  simulation.advance_to(0.5);
  ASSERT_EQ(simulation.world().connectors.size(), 2u);
  for (const Connector& part : simulation.world().connectors)
    for (const Vec3& at : part.position) EXPECT_LT(at.y(), -0.5);
}

}  // namespace
}  // namespace taut::ignored_test
