// How the links of a chain are placed and turned.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/mesh/connector_mesh.h"
#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut::link_frames_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

double angle(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

TEST(LinkFrames, AStraightChainsLinksStandAtRightAngles) {
  const std::vector<Vec3> particles = {Vec3(0, 0, 0), Vec3(0, -1, 0), Vec3(0, -2, 0)};
  const auto links = mesh::link_frames(particles, 4, {}, {});
  ASSERT_EQ(links.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((links[i].from - Vec3(0, -0.5 * double(i), 0)).norm(), 1e-15);
    EXPECT_LT((links[i].axis - Vec3(0, -1, 0)).norm(), 1e-15);
    EXPECT_NEAR(links[i].wide.norm(), 1, 1e-15);
    EXPECT_NEAR(links[i].wide.dot(links[i].axis), 0, 1e-15);
    if (i > 0) {
      EXPECT_NEAR(links[i].wide.dot(links[i - 1].wide), 0, 1e-15);
    }
  }
}

TEST(LinkFrames, AFoldedChainIsNotTwisted) {
  // Down, round a bend and up again, in one plane: every other link lies flat in it.
  std::vector<Vec3> particles;
  for (int i = 0; i <= 4; ++i) particles.emplace_back(0, -i, 0);
  particles.emplace_back(0.1, -4.99, 0);
  for (int i = 4; i >= 0; --i) particles.emplace_back(0.2, -i, 0);
  const Vec3 down(0, -1, 0);
  const auto links = mesh::link_frames(particles, 10, mesh::ChainHold{down, Vec3::UnitZ()},
                                       mesh::ChainHold{down, Vec3::UnitZ()});
  for (std::size_t i = 0; i < links.size(); ++i)
    EXPECT_NEAR(std::abs(links[i].wide.z()), i % 2 ? 0 : 1, 1e-12) << i;
}

/// The nunchaku's chain as it is drawn: how far links turn about themselves and swing within 1/960
/// s, how far neighbours are from right angles, and what is between a link and the next or what
/// holds it.
TEST(LongLinkFrames, LinksNeverSpinOverTheRoutine) {
  const scenes::Scene scene = scenes::load_scene(TAUT_SOURCE_DIR "/scenes/nunchaku.toml", false);
  Simulation simulation = scenes::start(scene);
  const Connector& chain = scene.world.connectors[0];
  const auto hold = [&](std::size_t end) {
    const Attachment& to = chain.holds[end].to;
    const Quat turn = simulation.state().bodies[to.body].rotation;
    return mesh::ChainHold{turn * Vec3::UnitY(), turn * Vec3::UnitX()};
  };
  std::vector<mesh::LinkFrame> last;
  double roll = 0, swing = 0;
  std::size_t fast = 0, twisted = 0, all = 0;
  for (int k = 0; k <= 960 * scene.duration; ++k) {
    simulation.advance_to(k / 960.0);
    const Snapshot state = simulation.state();
    const auto& particles = state.connectors[0];
    const mesh::BarEnd bars[] = {{particles.front(), hold(0).axis, 0.015, 0.004},
                                 {particles.back(), hold(1).axis, 0.015, 0.004}};
    const auto links = mesh::link_frames(mesh::clear_of(bars, particles), 10, hold(0), hold(1));
    for (std::size_t i = 0; i < links.size(); ++i) {
      const Vec3& next = i + 1 < links.size() ? links[i + 1].from : particles.back();
      ASSERT_LT((links[i].to - next).norm(), 1e-12);
      if (i > 0) {
        const Vec3 wide = mesh::transport(links[i - 1].wide, links[i - 1].axis, links[i].axis);
        twisted += std::abs(angle(wide, links[i].wide) / kDegree - 90) > 60;
      }
      if (last.empty()) continue;
      const double turned =
          angle(mesh::transport(last[i].wide, last[i].axis, links[i].axis), links[i].wide) /
          kDegree;
      roll = std::max(roll, turned);
      swing = std::max(swing, angle(last[i].axis, links[i].axis) / kDegree);
      fast += turned > 10;
      ++all;
    }
    last = links;
  }
  // A point on a link of 8 mm that rolls so moves less than the link's end that swings so.
  EXPECT_LT(roll, swing);
  EXPECT_LT(roll, 15);
  EXPECT_LT(fast, all / 10000);
  // Only links that are folded back, where an angle between them means little.
  EXPECT_LT(twisted, all / 500);
}

}  // namespace
}  // namespace taut::link_frames_test
