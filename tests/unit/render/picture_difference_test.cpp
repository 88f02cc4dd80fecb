#include <gtest/gtest.h>

#include <stdexcept>

#include "render/golden/golden.h"

namespace taut::picture_difference_test {
namespace {

TEST(PictureDifference, CountsPixelsThatDifferByMoreThanTwo) {
  picture::Picture a(100, 100), b(100, 100);
  EXPECT_TRUE(golden::same_rendering(golden::difference(a, b)));
  b.at(50, 50)[1] = 252;  // 3 off, in one pixel of 10,000
  EXPECT_DOUBLE_EQ(golden::difference(a, b).above_2, 1e-4);
  EXPECT_TRUE(golden::same_rendering(golden::difference(a, b)));
  b.at(10, 10)[0] = 200;
  const golden::PictureDifference d = golden::difference(a, b);
  EXPECT_EQ(d.largest, 55);
  EXPECT_FALSE(golden::same_rendering(d));
}

TEST(PictureDifference, FindsPixelsThatMovedByOneAgain) {
  picture::Picture still(100, 100), moved(100, 100), far(100, 100);
  still.at(50, 50)[2] = moved.at(51, 50)[2] = far.at(52, 50)[2] = 0;
  EXPECT_EQ(golden::difference(moved, still).near_above_8, 0);
  EXPECT_GT(golden::difference(far, still).near_above_8, 0);
}

TEST(PictureDifference, NeedsPicturesOfOneSize) {
  EXPECT_THROW(golden::difference(picture::Picture(100, 100), picture::Picture(10, 10)),
               std::invalid_argument);
}

}  // namespace
}  // namespace taut::picture_difference_test
