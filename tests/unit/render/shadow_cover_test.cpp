// Which triangles shadows can reach, also where floats run out of numbers.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "render/draw/shading/shadow_map.h"

namespace taut::shadow_cover_test {
namespace {

constexpr std::array<std::uint32_t, 3> kTriangle{0, 1, 2};

/// How many indices a cover finds in a triangle at that height (of the map), with a caster in the
/// middle of the map above it.
std::size_t found(const draw::Places& places) {
  draw::ShadowCover cover;
  cover.start(Eigen::Matrix4f::Identity(), 0, 0);
  const draw::Places caster{{0.4f, 0.4f, 0.2f}, {0.6f, 0.4f, 0.2f}, {0.5f, 0.6f, 0.2f}};
  cover.add(kTriangle, std::array{caster});
  std::vector<std::uint32_t> indices;
  cover.find(kTriangle, places, {}, indices);
  return indices.size();
}

TEST(ShadowCover, FindsWhatLiesBehindACasterAndNothingElse) {
  EXPECT_EQ(found({{0, 0, 0.5f}, {1, 0, 0.5f}, {0, 1, 0.5f}}), 3u);
  EXPECT_EQ(found({{0, 0, 0.1f}, {1, 0, 0.1f}, {0, 1, 0.1f}}), 0u) << "in front of it";
  EXPECT_EQ(found({{0, 0, 0.5f}, {0.1f, 0, 0.5f}, {0, 0.1f, 0.5f}}), 0u) << "beside it";
}

TEST(ShadowCover, PlacesThatAreNoNumbersAreNotReached) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  constexpr float kMost = std::numeric_limits<float>::infinity();
  EXPECT_EQ(found({{kNone, kNone, 0.5f}, {kNone, 0, 0.5f}, {0, kNone, 0.5f}}), 0u);
  EXPECT_EQ(found({{kMost, 0, 0.5f}, {kMost, 0, 0.5f}, {kMost, kMost, 0.5f}}), 0u);
  EXPECT_EQ(found({{-1e30f, -1e30f, 0.5f}, {1e30f, -1e30f, 0.5f}, {0, 1e30f, 0.5f}}), 3u);
}

}  // namespace
}  // namespace taut::shadow_cover_test
