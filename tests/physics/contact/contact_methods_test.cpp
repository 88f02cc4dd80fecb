// Contact found where steps end, in impulse, xpbd and springs: of first order in the step.
#include <gtest/gtest.h>

#include "contact_worlds.h"

namespace taut::contact_methods_test {
namespace {

using namespace contact_worlds;
using worlds::kGravity;

constexpr double kStep = 1.0 / 3840;  // s

class ContactByGames : public testing::TestWithParam<const char*> {
 protected:
  World after(const World& start, double time) const {
    Simulation simulation(start, make_method(GetParam(), {{"step", kStep}}));
    simulation.advance_to(time);
    return simulation.world();
  }
};

// The bounce comes up to a step late, at a speed that is up to a step's gravity off.
TEST_P(ContactByGames, ABeadBounces) {
  const double lands = std::sqrt(2 / kGravity);
  for (const double e : {0.0, 0.5, 1.0}) {
    const double time = 0.7, speed = e * kGravity * lands;
    const World world =
        after(pair(Vec3(0, 1, 0), Vec3::Zero(), obstacle(plane_shape(), 0, e)), time);
    const double flown = time - lands;
    const double height = e == 0 ? 0 : speed * flown - kGravity * flown * flown / 2;
    EXPECT_NEAR(world.connectors[0].position[0].y(), height, 4 * kStep * kGravity * lands) << e;
  }
}

// A bead that sticks may creep by its fall in a step, before friction stops it.
TEST_P(ContactByGames, ABeadOnAnInclineSlidesOrSticks) {
  const double angle = std::atan(0.5);
  for (const double mu : {0.2, 0.6}) {
    Obstacle incline = obstacle(plane_shape(), mu);
    incline.place.rotation = Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
    const World world = after(pair(Vec3::Zero(), Vec3::Zero(), incline), 1);
    const double down = kGravity * (std::sin(angle) - mu * std::cos(angle));
    EXPECT_NEAR(world.connectors[0].position[0].norm(), std::max(0.0, down / 2),
                2 * kStep * kGravity)
        << mu;
  }
}

// A rope comes to lie on a floor without sinking in.
TEST_P(ContactByGames, ARopeOnAFloor) {
  const World world = after(falling_rope(21, obstacle(plane_shape(), 0.5)), 3);
  EXPECT_LE(penetration(world), 1e-12);
  EXPECT_LT(fastest(world), 0.05);
}

INSTANTIATE_TEST_SUITE_P(All, ContactByGames, testing::Values("impulse", "xpbd", "springs"));

}  // namespace
}  // namespace taut::contact_methods_test
