// Two rings of one wire, to both sides of Michell's twist.
#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut::ring_scene_test {
namespace {

scenes::Scene shipped() {
  return scenes::load_scene(TAUT_SOURCE_DIR "/scenes/materials/ring.toml", false);
}

/// How far (m) a ring is from flat, along z.
double depth(const Connector& ring) {
  const auto [near, far] =
      std::ranges::minmax(ring.position, {}, [](const Vec3& at) { return at.z(); });
  return far.z() - near.z();
}

TEST(Ring, BucklesBeyondMichellsTwist) {
  const scenes::Scene scene = shipped();
  Simulation direct(scene.world, make_method("direct", {{"tolerance", 1e-3}}));
  Simulation truth(scene.world, make_method("truth", {}));
  for (Simulation* one : {&direct, &truth}) one->advance_to(scene.duration);
  const auto& rings = direct.world().connectors;
  // Turning by 0.01 rad/s makes a depth of its own.
  const double diameter = rings[0].length / M_PI;
  EXPECT_LT(depth(rings[0]), 1.1 * 0.01 * scene.duration * diameter);
  EXPECT_GT(depth(rings[1]), 0.3 * diameter);
  for (std::size_t c = 0; c < rings.size(); ++c) {
    for (std::size_t i = 0; i < rings[c].particles(); ++i) {
      const Vec3& there = truth.world().connectors[c].position[i];
      EXPECT_LT((rings[c].position[i] - there).norm(), 1e-3) << rings[c].name << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace taut::ring_scene_test
