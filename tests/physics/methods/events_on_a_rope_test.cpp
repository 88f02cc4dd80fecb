// Interventions on one part of a rope leave the others to their own steps.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/measure/measure.h"
#include "sim/motion/path.h"
#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::events_on_a_rope_test {
namespace {

/// A rope of 2 m that hangs between two nails, and is let go from a curve that is none at rest.
World slack_rope(std::size_t particles) {
  World world;
  Connector rope = straight_connector("rope", 2, 0.2, particles, Vec3::Zero(), Vec3(1, 0, 0));
  rope.holds = {{0, worlds::fixed_at(Vec3::Zero())},
                {particles - 1, worlds::fixed_at(Vec3(1.2, 0, 0))}};
  rope.position = hanging_points(rope, Vec3::Zero(), Vec3(1.2, 0, 0), Vec3(2, -9.81, 1));
  world.connectors = {rope};
  finish(world);
  return world;
}

double steps(std::size_t particles, std::size_t pins) {
  const World world = slack_rope(particles);
  Timeline timeline;
  for (std::size_t i = 0; i < pins; ++i) {
    const double along = 2 * (double(i * 7 % pins) + 0.5) / double(pins);
    timeline.pins.push_back(
        {.along = along, .from = 0.5 * (double(i) + 0.3) / double(pins), .to = {}});
  }
  Simulation simulation(world, make_method("direct", {{"tolerance", 1e-3}}), timeline);
  for (int frame = 1; frame <= 6; ++frame) simulation.advance_to(frame / 10.0);
  return double(simulation.method().counters().steps);
}

TEST(EventsOnARope, StepsGrowAsTheirNumberDoes) {
  for (const std::size_t particles : {11u, 161u}) {  // several pins a link, and several links a pin
    EXPECT_LT(steps(particles, 80) / steps(particles, 20), 4 * 1.2);  // 16 where each stops all
  }
}

/// Pins that last or go, that move, are drawn somewhere or hold a ball, and cuts; some at the same
/// time; the rope's second half hangs on a ball that flies.
struct Storm {
  World world = slack_rope(41);
  Timeline timeline;

  Storm() {
    Body ball;
    ball.name = "ball";
    ball.mass_properties = solid_sphere(0.2, 0.1);
    ball.position = Vec3(1.2, 0, 0);
    world.bodies = {ball};
    world.connectors[0].holds[1].to = {Attachment::Kind::body, Vec3::Zero(), nullptr, 0};
    world.topology = 0;
    finish(world);
    Attachment moving{Attachment::Kind::path, Vec3::Zero(), nullptr, 0};
    moving.path = std::make_shared<const Path>(std::vector<PathKey>{
        {0, {0.15, -0.4, 0}}, {0.3, {0.2, -0.38, 0.05}}, {1, {0.15, -0.3, 0}}});
    timeline.pins = {{.along = 0.31, .from = 0.05, .to = {}},
                     {.along = 0.7, .from = 0.08, .until = 0.2, .to = {}},
                     {.along = 1.6, .from = 0.08, .until = 0.16, .to = {}},
                     {.along = 1.45, .from = 0.11, .until = 0.22, .to = {}},
                     {.along = 0.5, .from = 0.03, .until = 0.26, .to = moving, .over = 0.04},
                     {.along = 1.12, .from = 0.13, .to = {}},
                     {.along = 1.3, .from = 0.2, .to = {}}};
    timeline.cuts = {{.along = 1.22, .time = 0.17}, {.along = 0.15, .time = 0.23}};
  }
};

TEST(EventsOnARope, MoveTheOthersAsTheTruthDoes) {
  for (const bool beside : {false, true}) {
    Storm storm;
    if (beside) {  // something else that nothing is done to: an island of its own
      storm.world.connectors.push_back(
          straight_connector("other", 1, 0.1, 5, Vec3(0, 3, 0), Vec3(1, 0, 0)));
      storm.world.topology = 0;
    }
    Simulation truth(storm.world, make_method("truth", {}), storm.timeline);
    Simulation direct(storm.world, make_method("direct", {{"tolerance", 1e-6}}), storm.timeline);
    for (int frame = 1; frame <= 10; ++frame) {
      truth.advance_to(frame / 33.0);
      direct.advance_to(frame / 33.0);
      const Snapshot expected = truth.state(), found = direct.state();
      ASSERT_EQ(found.connectors.size(), expected.connectors.size());
      for (std::size_t c = 0; c < expected.connectors.size(); ++c) {
        for (std::size_t i = 0; i < expected.connectors[c].size(); ++i) {
          const Vec3 apart = found.connectors[c][i] - expected.connectors[c][i];
          EXPECT_LT(apart.norm(), 1e-5) << frame << ' ' << c << ' ' << i;
        }
      }
      EXPECT_LT(stretch_max(direct.world()), 1e-9);
    }
  }
}

}  // namespace
}  // namespace taut::events_on_a_rope_test
