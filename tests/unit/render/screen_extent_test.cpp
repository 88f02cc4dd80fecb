// Which pixels can be touched: rectangles, hulls and shadows computed by hand.
#include <gtest/gtest.h>

#include <algorithm>

#include "render/draw/motion_extents.h"
#include "render/draw/shading/lighting.h"

namespace taut::screen_extent_test {
namespace {

using Box = Eigen::AlignedBox3f;
using Eigen::Vector3f;

TEST(RectSet, OverlapsBecomeOne) {
  picture::RectSet set;
  set.add({0, 0, 10, 10});
  set.add({20, 0, 10, 10});
  set.add({5, 5, 0, 3});  // empty
  EXPECT_EQ(set.end() - set.begin(), 2);
  set.add({9, 9, 12, 4});  // touches both
  ASSERT_EQ(set.end() - set.begin(), 1);
  const picture::Rect all = *set.begin();
  EXPECT_EQ(all.x, 0);
  EXPECT_EQ(all.right(), 30);
  EXPECT_EQ(all.top(), 13);
}

TEST(ScreenExtent, ShadowOnAFloorIsWhereLightMeetsIt) {
  // Light goes down and along x, one for one: what is at height h falls h further on.
  draw::HullPoints hull;
  draw::add_shadow(Box(Vector3f(0, 1, 0), Vector3f(1, 2, 1)), Vector3f(1, -1, 0),
                   Box(Vector3f(-9, 0, -9), Vector3f(9, 0, 9)), hull);
  Box found;
  for (const Vector3f& p : hull) found.extend(p);
  EXPECT_TRUE(found.min().isApprox(Vector3f(1, 0, 0)) && found.max().isApprox(Vector3f(3, 0, 1)))
      << found.min().transpose() << " to " << found.max().transpose();
  hull.clear();
  draw::add_shadow(Box(Vector3f(0, 1, 0), Vector3f(1, 2, 1)), Vector3f(1, -1, 0), Box(), hull);
  EXPECT_TRUE(hull.empty());
}

TEST(ScreenExtent, PixelsHoldWhatIsDrawn) {
  const Eigen::Matrix4f projection = draw::camera_projection({Vec3(0, 0, 4), Vec3::Zero(), 0.5}, 1);
  draw::HullPoints hull;
  draw::add_box(Box(Vector3f(-0.1f, -0.1f, 0), Vector3f(0.1f, 0.1f, 0)), hull);
  const picture::Rect view{50, 20, 200, 200};
  const picture::Rect part = draw::pixels(hull, projection, view);
  // A point 0.1 off the axis is 0.1 / (4 tan 0.25) of the half picture away from its middle.
  const double off = 100 * 0.1 / (4 * std::tan(0.25));
  EXPECT_NEAR(part.x, 50 + 100 - off - 1, 1);
  EXPECT_NEAR(part.right(), 50 + 100 + off + 1, 1);
  EXPECT_NEAR(part.y, 20 + 100 - off - 1, 1);
  hull.push_back(Vector3f(0, 0, 5));  // behind the eye
  EXPECT_EQ(draw::pixels(hull, projection, view).width, 200);
}

}  // namespace
}  // namespace taut::screen_extent_test
