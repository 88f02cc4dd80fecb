// The whip that narrows to its tip, and cracks.
#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut::whip_scene_test {
namespace {

constexpr double kSound = 340;                  // m/s
constexpr double kBefore = 0.2, kAfter = 0.28;  // s: the crack is between them

struct Crack {
  double hand = 0, tip = 0;  // m/s, the most
};

/// Looks at the tip `apart` s by `apart` s.
Crack crack_of(const std::string& method, const Settings& settings, double apart) {
  const scenes::Scene scene =
      scenes::load_scene(TAUT_SOURCE_DIR "/scenes/materials/whip_taper.toml", false);
  Simulation simulation(scene.world, make_method(method, settings), scene.timeline);
  Crack crack;
  for (double time = 0; time < kBefore; time += 1e-3) {
    simulation.advance_to(time);
    const Connector& thong = simulation.world().connectors[0];
    crack.hand = std::max(crack.hand, thong.velocity.front().norm());
  }
  for (double time = kBefore; time < kAfter; time += apart) {
    simulation.advance_to(time);
    crack.tip = std::max(crack.tip, simulation.world().connectors[0].velocity.back().norm());
  }
  return crack;
}

TEST(Whip, TheTipPassesTheSpeedOfSound) {
  const Crack crack = crack_of("direct", {{"tolerance", 1e-3}}, 2e-4);
  EXPECT_LT(crack.hand, 20);
  EXPECT_GT(crack.tip, kSound);
}

// 0.01: what a look every 20 us may miss of a crack that lasts a tenth of a millisecond.
TEST(LongWhip, AsFastAsInTheTruth) {
  const double found = crack_of("direct", {{"tolerance", 1e-3}}, 2e-5).tip;
  const double truth = crack_of("truth", {}, 2e-5).tip;
  EXPECT_NEAR(found / truth, 1, 0.01);
}

}  // namespace
}  // namespace taut::whip_scene_test
