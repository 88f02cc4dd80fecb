// A chain lies on the ends of the sticks it hangs on.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render/mesh/connector_mesh.h"
#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut::chain_contact_test {
namespace {

const mesh::BarEnd kBar{Vec3::Zero(), Vec3::UnitY(), 0.015, 0.004};

TEST(ChainContact, DistanceIsThatToTheRoundedEnd) {
  EXPECT_NEAR(mesh::distance(kBar, Vec3(0, 0.003, 0)), 0.003, 1e-15);
  EXPECT_NEAR(mesh::distance(kBar, Vec3(0, -0.001, 0.005)), -0.001, 1e-15);
  EXPECT_NEAR(mesh::distance(kBar, Vec3(0.02, -0.1, 0)), 0.005, 1e-15);
  EXPECT_NEAR(mesh::distance(kBar, Vec3(0.012, -0.1, 0)), -0.003, 1e-15);
  // Beyond the rim, from its rounding's middle at (0.011, -0.004).
  EXPECT_NEAR(mesh::distance(kBar, Vec3(0.017, 0.004, 0)), 0.006, 1e-15);
}

TEST(ChainContact, AChainThatHangsFreeStaysAsItIs) {
  const std::vector<Vec3> up = {Vec3::Zero(), Vec3(0, 0.01, 0), Vec3(0.01, 0.01, 0)};
  EXPECT_EQ(mesh::clear_of({&kBar, 1}, up), up);
}

TEST(ChainContact, ASlackChainPulledBackGoesRoundTheRim) {
  // From the end's middle back through the bar, out of its side, and up again.
  std::vector<Vec3> points;
  for (int i = 0; i <= 4; ++i) points.emplace_back(0.006 * i, -0.0104 * i, 0);
  for (int i = 1; i <= 6; ++i) points.push_back(points[4] + Vec3(0, 0.012 * i, 0));
  const std::vector<Vec3> clear = mesh::clear_of({&kBar, 1}, points);
  EXPECT_EQ(clear.front(), points.front());
  EXPECT_EQ(clear.back(), points.back());
  for (const Vec3& p : clear) EXPECT_GT(mesh::distance(kBar, p), -1e-12);
  for (std::size_t i = 0; i < 10; ++i) {
    const double length = (points[i + 1] - points[i]).norm();
    EXPECT_NEAR((clear[i + 1] - clear[i]).norm() / length, 1, 0.15) << i;
  }
}

/// Over the routine no joint of the chain is inside the ferrules, and drawing it so hardly
/// stretches it.
TEST(LongChainContact, KeepsTheRoutinesChainOutOfTheFerrules) {
  const scenes::Scene scene = scenes::load_scene(TAUT_SOURCE_DIR "/scenes/nunchaku.toml", false);
  Simulation simulation = scenes::start(scene);
  const Connector& chain = scene.world.connectors[0];
  double deepest = 0, longest = 0;
  std::size_t moved = 0;
  for (int k = 0; k <= 480 * scene.duration; ++k) {
    simulation.advance_to(k / 480.0);
    const Snapshot state = simulation.state();
    const auto& points = state.connectors[0];
    std::vector<mesh::BarEnd> bars;
    for (const Hold& hold : chain.holds)
      bars.push_back({points[hold.particle], state.bodies[hold.to.body].rotation * Vec3::UnitY(),
                      0.015, 0.004});
    const auto clear = mesh::clear_of(bars, points);
    moved += clear != points;
    for (std::size_t i = 0; i + 1 < clear.size(); ++i) {
      longest = std::max(longest, (clear[i + 1] - clear[i]).norm() / chain.rest[i]);
      for (const mesh::BarEnd& bar : bars)
        if (i > 0) deepest = std::max(deepest, -mesh::distance(bar, clear[i]));
    }
  }
  EXPECT_GT(moved, 0u);
  EXPECT_LT(deepest, 1e-9);
  EXPECT_LT(longest, 1.2);
}

}  // namespace
}  // namespace taut::chain_contact_test
