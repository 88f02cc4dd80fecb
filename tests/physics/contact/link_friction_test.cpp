// Links that stick and slide on a post, by the direct method.
#include <gtest/gtest.h>

#include "contact_worlds.h"
#include "sim/measure/measure.h"

namespace taut::link_friction_test {
namespace {

using namespace contact_worlds;

constexpr double kLink = 0.02;  // m

/// A chain over half a turn of a post, which its links touch with their middles, or its beads.
World over(bool links, std::size_t arc, std::size_t left, std::size_t right, double friction) {
  World world = over_post(arc, 0, left, right, kLink, 0.2, friction);
  Connector& chain = world.connectors[0];
  chain.links_touch = links;
  if (links) {
    const double half = std::numbers::pi / static_cast<double>(arc) / 2;
    world.obstacles = {post(kLink / (2 * std::tan(half)), Vec3::Zero(), friction)};
  }
  finish(world);
  return world;
}

/// Where one side is lighter by less than exp(friction x angle) by far, nothing slides.
TEST(LinkFriction, AChainThatFrictionHoldsStays) {
  for (const std::size_t arc : {12u, 60u}) {
    const World world = over(true, arc, arc / 2, arc / 2 + arc / 4, 0.3);
    Simulation simulation = by_direct(world);
    simulation.advance_to(0.5);
    for (std::size_t end : {std::size_t{0}, world.connectors[0].particles() - 1}) {
      const Vec3 moves =
          simulation.world().connectors[0].position[end] - world.connectors[0].position[end];
      EXPECT_LT(moves.norm(), 1e-4) << arc << " its tolerance";
    }
    EXPECT_LT(fastest(simulation.world()), 1e-3) << arc;
  }
}

/// What sticks and what slides is told apart with solves of the order that beads take, of which one
/// a step is enough where all rests.
TEST(LinkFriction, ManyLinksTakeTheOrderOfSolvesThatBeadsTake) {
  double solves[2] = {};
  for (const std::size_t right : {std::size_t{40}, std::size_t{70}}) {
    for (const bool links : {false, true}) {
      Simulation simulation = by_direct(over(links, 60, 30, right, 0.3), 1e-3);
      simulation.advance_to(0.3);
      solves[links] += static_cast<double>(simulation.method().counters().solves);
    }
  }
  EXPECT_LT(solves[1], 8 * solves[0]) << solves[0] << " with beads";
}

}  // namespace
}  // namespace taut::link_friction_test
