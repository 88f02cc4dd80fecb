// What is asked for changes no motion: where things touch, `direct` takes steps of its own.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "contact_sticks.h"
#include "sim/measure/measure.h"
#include "sim/run/trajectory.h"
#include "tests/support/dice.h"

namespace taut::asked_times_test {
namespace {

using namespace contact_sticks;

struct Asked {
  const char* name;
  World world;
  Timeline timeline = {};
  Settings settings = {{"tolerance", 1e-3}};
};

/// A rope that falls on its radius over posts and a floor, with friction.
World rope_among_posts(bool links_touch, bool pulls) {
  World world;
  Connector rope =
      straight_connector("rope", 1, 0.1, 15, Vec3(-0.5, 0.7, 0), Vec3(1, 0.2, 0.05).normalized());
  rope.radius = 0.005;
  rope.links_touch = links_touch;
  rope.pulls = pulls;
  world.connectors = {rope};
  world.obstacles = {obstacle(plane_shape(), 0.4, 0.3), post(0.06, Vec3(0.05, 0.4, 0), 0.5),
                     post(0.04, Vec3(-0.3, 0.2, 0), 0.2)};
  finish(world);
  return world;
}

/// Far from a post at first, and for a while after it has met it.
World swings_by(double friction) {
  World world = worlds::chain(13, 1, Vec3::UnitX(), 0.1);
  world.connectors[0].radius = 0.005;
  world.obstacles = {post(0.05, Vec3(-0.2, -0.8, 0), friction)};
  world.topology = structure(world);
  return world;
}

/// A stick on a rope that is led along a path, over a drum that turns.
World led_stick() {
  World world = worlds::chain(7, 0.6, Vec3::UnitX(), 0.05);
  Body stick = leaning(Vec3(0.6 + kLength / 2, 0, 0), 0);
  stick.rotation = Quat(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()));
  world.bodies = {stick};
  Connector& rope = world.connectors[0];
  rope.holds[0].to = worlds::on_path(std::make_shared<const Path>(
      std::vector<PathKey>{{0.1, Vec3::Zero(), Quat::Identity(), true},
                           {0.5, Vec3(0.2, 0.1, 0), Quat::Identity(), true}}));
  rope.holds.push_back({6, worlds::on_body(0, kLength / 2 * Vec3::UnitY())});
  Obstacle drum = post(0.05, Vec3(0.1, -0.9, 0), 0.3);
  drum.path = std::make_shared<const Path>(
      std::vector<PathKey>{{0, Vec3::Zero(), Quat::Identity(), true},
                           {0.8, Vec3::Zero(), Quat(Eigen::AngleAxisd(2, Vec3::UnitY())), true}});
  world.obstacles = {drum};
  finish(world);
  return world;
}

std::vector<Asked> all() {
  std::vector<Asked> made{{"beads", rope_among_posts(false, false)},
                          {"beads, with a fixed step", rope_among_posts(false, false)},
                          {"beads that are pinned and cut", rope_among_posts(false, false)},
                          {"strings", rope_among_posts(false, true)},
                          {"links", rope_among_posts(true, false)},
                          {"mostly far from anything", swings_by(0.3)},
                          {"a body on a rope", led_stick()},
                          {"bodies", storm(3)}};
  made[1].settings["step"] = 1.3e-3;
  made[2].timeline.pins = {{0, 0.5, 0.2103, 0.4007, {}}};
  made[2].timeline.cuts = {{0, 0.15, 0.5001}};
  return made;
}

/// The hash of the state at each twentieth of a second, where the times in between are asked for.
std::vector<std::uint64_t> hashes(const Asked& asked, const std::vector<double>& between) {
  Simulation simulation(asked.world, make_method("direct", asked.settings), asked.timeline);
  std::vector<std::uint64_t> found;
  for (int k = 1; k <= 16; ++k) {
    for (const double share : between) {
      simulation.advance_to((k - 1 + share) / 20);
      const World& now = simulation.world();
      EXPECT_LE(penetration(now), 1e-9) << asked.name << ' ' << now.time;
      EXPECT_LE(penetration_of_links(now), 1e-9) << asked.name << ' ' << now.time;
      EXPECT_LE(depth(now), 1e-9) << asked.name << ' ' << now.time;
      EXPECT_LE(stretch_max(now), 1e-9) << asked.name << ' ' << now.time;
    }
    simulation.advance_to(k / 20.0);
    found.push_back(state_hash(simulation.world()));
  }
  return found;
}

TEST(LongAskedTimes, ChangeNoBitOfTheTrajectory) {
  std::vector<double> frames, exposures, many;
  for (int i = 1; i < 3; ++i) frames.push_back(i / 3.0);
  Dice dice(1);
  for (int i = 0; i < 3; ++i) {
    if (i > 0) exposures.push_back(i / 3.0);
    for (int k = 0; k < 16; ++k) exposures.push_back((i + (k + dice.between(0, 1)) / 16) / 3);
  }
  std::ranges::sort(exposures);
  for (int i = 1; i < 50; ++i) many.push_back(i / 50.0);
  for (const Asked& asked : all()) {
    const std::vector<std::uint64_t> alone = hashes(asked, {});
    EXPECT_EQ(alone, hashes(asked, frames)) << asked.name;
    EXPECT_EQ(alone, hashes(asked, exposures)) << asked.name;
    EXPECT_EQ(alone, hashes(asked, many)) << asked.name;
  }
}

}  // namespace
}  // namespace taut::asked_times_test
