// Ropes among obstacles that nobody chose: seeded worlds of all shapes, at rest and in motion.
#include <gtest/gtest.h>

#include "contact_worlds.h"
#include "sim/measure/measure.h"
#include "tests/support/dice.h"

namespace taut::contact_storm_test {
namespace {

using namespace contact_worlds;

Shape any_shape(Dice& dice) {
  const double size = dice.scale(0.05, 0.3), length = dice.scale(0.1, 1);
  switch (dice.pick(4)) {
    case 0:
      return sphere_shape(size);
    case 1:
      return capsule_shape(size, length);
    case 2:
      return cylinder_shape(size, length, 0.3 * std::min(size, length / 2));
    default:
      return box_shape(Vec3(size, length, size), 0.1 * std::min(size, length));
  }
}

/// A rope that is thrown among three obstacles, one of which moves, above a floor.
World storm(unsigned seed, bool links_touch, Timeline& timeline) {
  Dice dice(seed);
  World world;
  const auto particles = static_cast<std::size_t>(5 + dice.pick(30));
  Connector rope = straight_connector("rope", 1, dice.scale(0.02, 1), particles, Vec3(0, 1.5, 0),
                                      dice.direction());
  rope.radius = dice.between(0, 0.01);
  rope.links_touch = links_touch;
  const Vec3 velocity = dice.within(3), spin = dice.within(2);
  for (std::size_t i = 0; i < particles; ++i) {
    rope.velocity[i] = velocity + spin.cross(rope.position[i] - rope.position[0]);
  }
  if (dice.pick(2) == 0) {
    rope.holds = {{0, worlds::fixed_at(rope.position[0])}};
    for (std::size_t i = 0; i < particles; ++i) {
      rope.velocity[i] = spin.cross(rope.position[i] - rope.position[0]);
    }
  }
  world.connectors = {rope};
  const auto surface = [&](const Shape& shape) {
    Obstacle made = obstacle(shape, dice.between(0, 2), dice.between(0, 1));
    made.kinetic_friction *= dice.between(0.5, 1);
    return made;
  };
  world.obstacles = {surface(plane_shape())};
  for (int k = 0; k < 3; ++k) {
    Obstacle made = surface(any_shape(dice));
    made.place = {Vec3(dice.between(-0.6, 0.6), dice.between(0, 0.4), dice.between(-0.6, 0.6)),
                  Quat(Eigen::AngleAxisd(dice.radians(0, 360), dice.direction()))};
    if (k == 0) {
      const Quat turned(Eigen::AngleAxisd(dice.radians(0, 170), dice.direction()));
      made.path = std::make_shared<const Path>(std::vector<PathKey>{
          {0.1, Vec3::Zero(), Quat::Identity(), true}, {0.9, dice.within(0.5), turned, true}});
    }
    world.obstacles.push_back(made);
  }
  finish(world);
  if (dice.pick(2) == 0) {
    timeline.pins = {
        {0, dice.between(0.3, 0.7), dice.between(0.1, 0.5), dice.between(0.5, 0.9), {}}};
  }
  if (dice.pick(3) == 0) timeline.cuts = {{0, dice.between(0.35, 0.65), dice.between(0.2, 0.9)}};
  return world;
}

void weather(unsigned first, unsigned count, bool links_touch) {
  for (unsigned seed = first; seed < first + count; ++seed) {
    Timeline timeline;
    const World world = storm(seed, links_touch, timeline);
    Simulation simulation(world, make_method("direct", {{"tolerance", 1e-3}}), timeline);
    try {
      for (int frame = 1; frame <= 60; ++frame) {
        simulation.advance_to(frame / 60.0);
        ASSERT_TRUE(std::isfinite(kinetic_energy(simulation.world()))) << seed;
        // The restored links of a pin that was between beads may lead one inside.
        if (timeline.pins.empty()) {
          ASSERT_LE(penetration(simulation.world()), 1e-9) << seed;
          ASSERT_LE(penetration_of_links(simulation.world()), 1e-9) << seed;
        }
        ASSERT_LT(stretch_max(simulation.world()), 1e-6) << seed;
      }
    } catch (const BadIntervention& error) {
      // Obstacles move over beads that are pinned, and a link may pass through one where it is cut.
      EXPECT_NE(std::string(error.what()).find("inside of obstacle"), std::string::npos)
          << seed << ": " << error.what();
    } catch (const Diverged& error) {
      ADD_FAILURE() << seed << ": " << error.what();
    }
  }
}

class ContactStorm : public testing::TestWithParam<bool> {};

TEST_P(ContactStorm, TenWorlds) {
  weather(1, 10, GetParam());
}

class LongContactStorm : public testing::TestWithParam<bool> {};

TEST_P(LongContactStorm, AHundredWorlds) {
  weather(1, 100, GetParam());
}

const auto named = [](const testing::TestParamInfo<bool>& of) {
  return of.param ? "WithLinks" : "WithBeads";
};
INSTANTIATE_TEST_SUITE_P(Both, ContactStorm, testing::Bool(), named);
INSTANTIATE_TEST_SUITE_P(Long, LongContactStorm, testing::Bool(), named);

}  // namespace
}  // namespace taut::contact_storm_test
