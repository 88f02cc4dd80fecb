#include "render/golden/picture_difference.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace taut {
namespace {

TEST(PictureDifference, CountsPixelsThatDifferByMoreThanTwo) {
  Picture a(100, 100), b(100, 100);
  EXPECT_TRUE(same_rendering(difference(a, b)));
  b.at(50, 50)[1] = 252;  // 3 off, in one pixel of 10,000
  EXPECT_DOUBLE_EQ(difference(a, b).above_2, 1e-4);
  EXPECT_TRUE(same_rendering(difference(a, b)));
  b.at(10, 10)[0] = 200;
  const PictureDifference d = difference(a, b);
  EXPECT_EQ(d.largest, 55);
  EXPECT_FALSE(same_rendering(d));
}

TEST(PictureDifference, FindsPixelsThatMovedByOneAgain) {
  Picture still(100, 100), moved(100, 100), far(100, 100);
  still.at(50, 50)[2] = moved.at(51, 50)[2] = far.at(52, 50)[2] = 0;
  EXPECT_EQ(difference(moved, still).near_above_8, 0);
  EXPECT_GT(difference(far, still).near_above_8, 0);
}

TEST(PictureDifference, NeedsPicturesOfOneSize) {
  EXPECT_THROW(difference(Picture(100, 100), Picture(10, 10)), std::invalid_argument);
}

}  // namespace
}  // namespace taut
