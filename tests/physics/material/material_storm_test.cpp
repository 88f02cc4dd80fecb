// Drawn ropes of all materials: the truth and direct, two ways to step, agree within the tolerance.
#include <gtest/gtest.h>

#include "material_worlds.h"
#include "tests/support/dice.h"

namespace taut::material_storm_test {
namespace {

using namespace material_worlds;

struct DrawnRope {
  World world;
  double tolerance = 0;  // m
};

bool likely(Dice& dice, double share) {
  return dice.between(0, 1) < share;
}

/// Held at one end or both, or thrown; stretching, bending, damped, in wind, loaded, or not.
DrawnRope drawn(unsigned seed) {
  Dice dice(seed);
  const auto links = static_cast<std::size_t>(4 + dice.between(0, 9));
  const double mass = dice.scale(1e-2, 1);
  const double weight = mass * worlds::kGravity;
  const bool stretches = likely(dice, 0.6), is_thrown = likely(dice, 0.2);
  const double axial = weight * dice.scale(1e-1, 1e3);
  const double bending = likely(dice, 0.7) ? weight * dice.scale(1e-5, 1) : 0;
  Section made = section(stretches ? axial : kRigid, bending);
  if (stretches && likely(dice, 0.4)) {
    made.axial_damping = made.axial_stiffness * dice.scale(1e-4, 1e-2);
  }
  if (likely(dice, 0.4)) {
    made.bending_damping = made.bending_stiffness * dice.scale(1e-4, 1e-2);
  }
  World world;
  Connector rope = straight_connector("rope", 1, mass, links + 1, Vec3::Zero(), dice.direction());
  const Vec3 along = rope.position[1].normalized();
  rope.sections.assign(links, made);
  Hold hold;
  if (made.bending_stiffness > 0 && likely(dice, 0.5)) {
    hold.clamp = along + 0.2 * dice.direction();
  }
  if (!is_thrown) rope.holds = {hold};
  if (is_thrown) {
    for (std::size_t i = 0; i <= links; ++i) {
      rope.velocity[i] = Vec3(1, 2, 0) + Vec3(0, 3, 1).cross(rope.position[i]);
    }
  } else if (stretches && likely(dice, 0.2)) {
    Hold end;
    end.particle = links;
    end.to.point = rope.position.back();
    rope.holds.push_back(end);
  }
  if (likely(dice, 0.4)) {
    rope.drag = {1.2, dice.between(0, 0.2)};
    world.air = {1.2, dice.within(Vec3(5, 0, 5))};
  }
  if (likely(dice, 0.4)) rope.particle_mass.back() += mass * dice.scale(1e-1, 1e2);
  world.connectors = {rope};
  finish(world);
  return {world, std::pow(10, -1 - dice.pick(6))};
}

TEST(MaterialStorm, DirectAndTheTruthAgree) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const DrawnRope rope = drawn(seed);
    const World truth = after(rope.world, 0.25, "truth", {{"local_error", 1e-11}});
    EXPECT_LT(apart(after(rope.world, 0.25, rope.tolerance), truth), rope.tolerance) << seed;
  }
}

}  // namespace
}  // namespace taut::material_storm_test
