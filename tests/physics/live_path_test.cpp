// A path that is replaced in place while a simulation runs, as by a mouse.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/run/simulation.h"

namespace taut::live_path_test {
namespace {

constexpr double kFrame = 1.0 / 60;  // s

PathKey key_at(int frame) {
  const double t = frame * kFrame;
  return {.time = t,
          .position = Vec3(0.1 * (1 - std::cos(6 * t)), 0.05 * std::sin(9 * t), 0),
          .ease = true,
          .velocity = Vec3(0.6 * std::sin(6 * t), 0.45 * std::cos(9 * t), 0)};
}

World rope_on(const std::shared_ptr<const Path>& path) {
  World world;
  world.connectors = {straight_connector("rope", 1.0, 0.1, 21, Vec3::Zero(), Vec3::UnitX())};
  world.connectors[0].holds = {
      {.particle = 0, .to = {.kind = Attachment::Kind::path, .path = path}}};
  world.connectors[0].particle_mass.back() += 0.2;  // kg
  return world;
}

World stick_on(const std::shared_ptr<const Path>& path) {
  World world;
  const Vec3 tip(0, 0.15, 0);
  Body held;
  held.name = "held";
  held.mass_properties = solid_cylinder(0.12, 0.3, 0.028);
  Body stick = held;
  held.path = path;
  stick.name = "stick";
  Connector chain = straight_connector("chain", 0.12, 0.012, 11, tip, Vec3(1, -1, 0).normalized());
  stick.position = chain.position.back() - tip;
  Attachment first, last;
  first.kind = last.kind = Attachment::Kind::body;
  first.point = last.point = tip;
  last.body = 1;
  chain.holds = {{.particle = 0, .to = first}, {.particle = 10, .to = last}};
  world.bodies = {held, stick};
  world.connectors = {chain};
  return world;
}

/// The motion is that of the same path known from the start: methods do not look beyond the time
/// that they advance to, and what they remember stays valid.
TEST(LivePath, MovesAsIfItHadBeenKnown) {
  constexpr int kFrames = 40;
  const std::vector<MethodChoice> methods = {{"direct", {{"tolerance", 1e-8}}},
                                             {"xpbd", {}},
                                             {"springs", {}},
                                             {"dynamic-constraints", {}},
                                             {"impulse", {}}};
  for (World (*world)(const std::shared_ptr<const Path>&) : {rope_on, stick_on}) {
    for (const MethodChoice& choice : methods) {
      std::vector<PathKey> keys;
      for (int frame = 0; frame <= kFrames; ++frame) keys.push_back(key_at(frame));
      Simulation known(world(std::make_shared<Path>(keys)),
                       make_method(choice.name, choice.settings));
      const auto path = std::make_shared<Path>(std::vector<PathKey>{key_at(0)});
      Simulation live(world(path), make_method(choice.name, choice.settings));
      for (int frame = 1; frame <= kFrames; ++frame) {
        *path = Path({key_at(frame - 1), key_at(frame)});
        live.advance_to(frame * kFrame);
        known.advance_to(frame * kFrame);
      }
      const Snapshot one = known.state(), other = live.state();
      double error = 0;
      for (std::size_t i = 0; i < one.connectors[0].size(); ++i) {
        error = std::max(error, (one.connectors[0][i] - other.connectors[0][i]).norm());
      }
      EXPECT_LT(error, 1e-7) << choice.name << (one.bodies.empty() ? ", rope" : ", stick");
      EXPECT_GT((one.connectors[0][0] - world(path).connectors[0].position[0]).norm(), 0.05);
    }
  }
}

}  // namespace
}  // namespace taut::live_path_test
