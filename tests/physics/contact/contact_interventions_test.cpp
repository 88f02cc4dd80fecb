// Every method refuses, in the same words, to let go of a bead inside of an obstacle.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "contact_worlds.h"
#include "scenes/load/load_scene.h"
#include "sim/run/method.h"

namespace taut::contact_interventions_test {
namespace {

using namespace contact_worlds;

constexpr double kLength = 1, kRadius = 0.01;  // m

/// A rope of five beads that lies still, straight over a ball of which the top is `above` (m) over
/// the middle of its second link, or of its third bead.
World over_a_ball(double x, double above) {
  constexpr double kBall = 0.05;  // m, its radius: no other bead is near
  World world;
  Connector rope = straight_connector("rope", kLength, 0.5, 5, Vec3::Zero(), Vec3::UnitX());
  rope.radius = kRadius;
  world.connectors = {rope};
  world.obstacles = {obstacle(sphere_shape(kBall))};
  world.obstacles[0].place.position = Vec3(x, above - kBall, 0);
  world.gravity = Vec3::Zero();
  finish(world);
  return world;
}

/// The words of each method that follows the world about the timeline; empty: none.
std::vector<std::pair<std::string, std::string>> said(const World& world,
                                                      const Timeline& timeline) {
  std::vector<std::pair<std::string, std::string>> all;
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty() || !follows(method, world)) continue;
    std::string& says = all.emplace_back(method.name, "").second;
    try {
      Simulation simulation(world, make_method(method.name, {}), timeline);
      simulation.advance_to(0.02);
    } catch (const BadIntervention& error) {
      says = error.what();
    }
  }
  EXPECT_GE(all.size(), 4u);  // truth, direct, springs and xpbd
  return all;
}

TEST(ContactInterventions, ACutInALinkThatPassesThroughAnObstacle) {
  const World world = over_a_ball(0.375, 0.002);
  for (const auto& [method, says] : said(world, {.pins = {}, .cuts = {{0, 0.375, 0.01}}})) {
    // The new bead reaches 0.01 m below the line, and the ball 0.002 m above it.
    EXPECT_EQ(says,
              "cut 1, at 0.01 s: it frees a bead 0.012 m inside of obstacle obstacle, expected a "
              "place or time where the bead is outside")
        << method;
  }
  for (const auto& [method, says] : said(world, {.pins = {}, .cuts = {{0, 0.25, 0.01}}})) {
    EXPECT_EQ(says, "") << method;  // at a bead that is outside
  }
}

TEST(ContactInterventions, APinThatIsTakenAwayInsideOfAnObstacle) {
  for (const double above : {-0.002, -0.02}) {  // the second: the bead does not reach so far
    const World world = over_a_ball(0.5, above);
    for (const auto& [method, says] : said(world, {.pins = {{0, 0.5, 0, 0.01, {}}}, .cuts = {}})) {
      EXPECT_EQ(says, above < -kRadius ? ""
                                       : "pin 1, at 0.01 s: it frees a bead 0.008 m inside of "
                                         "obstacle obstacle, expected a place or time where the "
                                         "bead is outside")
          << method;
    }
  }
}

// The pin catches the middle of a rope that is straight, so that its upper half is at its full
// length between two places and trembles. The lower half swings as it does without the ball, which
// is near enough for implicit steps and touches nothing.
TEST(ContactInterventions, APinAtFullLengthBesideABall) {
  const scenes::Scene scene = scenes::load_scene(TAUT_SOURCE_DIR "/scenes/pin.toml", false);
  World beside = scene.world;
  beside.connectors[0].radius = kRadius;
  beside.obstacles = {obstacle(sphere_shape(0.05))};
  beside.obstacles[0].place.position = Vec3(-0.065, 1.35, 0);
  finish(beside);
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    const Settings settings{{"tolerance", tolerance}};
    Simulation alone(scene.world, make_method("direct", settings), scene.timeline);
    Simulation near(beside, make_method("direct", settings), scene.timeline);
    for (Simulation* each : {&alone, &near}) each->advance_to(0.9);
    double sum = 0;
    const Connector &found = near.world().connectors[0], &known = alone.world().connectors[0];
    const std::size_t pinned = found.particles() / 2;
    for (std::size_t i = pinned; i < found.particles(); ++i) {
      sum += (found.position[i] - known.position[i]).squaredNorm();
    }
    EXPECT_LT(std::sqrt(sum / double(found.particles() - pinned)), 2 * tolerance);
  }
}

}  // namespace
}  // namespace taut::contact_interventions_test
