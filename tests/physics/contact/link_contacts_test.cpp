// Links that touch obstacles between their beads, as games do it.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/run/simulation.h"
#include "sim/world/world.h"
#include "tests/physics/worlds.h"

namespace taut::link_contacts_test {
namespace {

constexpr double kStep = 1e-4;                   // s
constexpr double kPost = 0.01, kRadius = 0.005;  // m: radii of the post and of the rope
constexpr double kHeight = 0.1;                  // m, of the line through the beads at the start

/// A rope that lies across a thin post along z, whose nearest beads are aside.
World rope_across_post(std::size_t particles, double aside) {
  World world;
  world.gravity = Vec3(0, -9.81, 0);
  world.connectors.push_back(
      straight_connector("rope", 1, 0.1, particles, Vec3(aside - 0.5, kHeight, 0), Vec3::UnitX()));
  Connector& rope = world.connectors.front();
  rope.radius = kRadius;
  rope.links_touch = true;
  Obstacle post;
  post.name = "post";
  post.shape = capsule_shape(kPost, 1);
  post.place.rotation = Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()));
  world.obstacles.push_back(post);
  return world;
}

Settings settings() {
  return {{"step", kStep}};
}

double least_distance(const World& world) {
  double least = INFINITY;
  const Connector& rope = world.connectors.front();
  for (std::size_t k = 0; k + 1 < rope.particles(); ++k) {
    for (int i = 0; i <= 100; ++i) {
      const Vec3 at = rope.position[k] + i / 100.0 * (rope.position[k + 1] - rope.position[k]);
      least = std::min(least, std::hypot(at.x(), at.y()));
    }
  }
  return least - kPost - kRadius;
}

class LinkContacts : public testing::TestWithParam<const char*> {};

TEST_P(LinkContacts, ALinkThatIsBalancedComesToRest) {
  Simulation simulation(rope_across_post(2, 0), make_method(GetParam(), settings()));
  simulation.advance_to(1);
  const Connector& rod = simulation.world().connectors.front();
  for (int end : {0, 1}) {
    EXPECT_NEAR(rod.position[end].y(), kPost + kRadius, 1e-9);
    EXPECT_LT(rod.velocity[end].norm(), 1e-9);
  }
}

// The point at the post is stopped by an impulse P: a bead at the distance d of it, of mass m and
// with the share s = 1 - d/l of the lever, gets s P/m.
TEST_P(LinkContacts, AnImpactTurnsALinkByItsLevers) {
  constexpr double aside = 0.2, length = 1;
  Simulation simulation(rope_across_post(2, aside), make_method(GetParam(), settings()));
  const double fall = kHeight - kPost - kRadius, speed = std::sqrt(2 * 9.81 * fall);
  const double near = 0.5 - aside, far = 0.5 + aside;
  const double first = far / length, last = near / length;  // shares of the lever
  const double impulse = speed / (first * first + last * last);
  simulation.advance_to(std::sqrt(2 * fall / 9.81) + 5e-3);
  const Connector& rod = simulation.world().connectors.front();
  // The next 5 ms add gravity and a few degrees of turning.
  EXPECT_NEAR(rod.velocity[0].y(), first * impulse - speed, 0.05);
  EXPECT_NEAR(rod.velocity[1].y(), last * impulse - speed, 0.05);
  EXPECT_NEAR(first * rod.velocity[0].y() + last * rod.velocity[1].y(), 0, 0.01);
}

TEST_P(LinkContacts, AThinPostSlipsBetweenNoBeads) {
  for (const bool touch : {true, false}) {
    World world = rope_across_post(12, 0);  // a bead is 45 mm aside of the post at least
    world.connectors.front().links_touch = touch;
    Simulation simulation(world, make_method(GetParam(), settings()));
    double least = INFINITY;
    for (double time = 0.01; time < 0.35; time += 0.01) {
      simulation.advance_to(time);
      least = std::min(least, least_distance(simulation.world()));
    }
    if (touch) {
      EXPECT_GT(least, -1e-4) << "a link is stretched by what moves it out, and then drawn back";
    } else {
      EXPECT_LT(least, -kPost) << "the post is in between";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AsGamesDo, LinkContacts, testing::Values("xpbd", "springs"));

TEST(LinkContacts, OthersRefuseThemByName) {
  for (const MethodInfo& method : all_methods()) {
    if (method.abilities.follows.has(Feature::links_touch) ||
        !method.abilities.follows.has(Feature::obstacle) || !method.missing.empty())
      continue;
    Simulation simulation(rope_across_post(3, 0), make_method(method.name, {}));
    try {
      simulation.advance_to(0.01);
      ADD_FAILURE() << method.name;
    } catch (const Diverged& refused) {
      EXPECT_NE(std::string(refused.what()).find("capsule links"), std::string::npos)
          << refused.what();
    }
  }
}

}  // namespace
}  // namespace taut::link_contacts_test
