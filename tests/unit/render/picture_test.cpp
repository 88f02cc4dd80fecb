// PNG files of our own making, read back by libpng.
#include "render/picture/picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "render/picture/text.h"
#include "tests/support/folder.h"

namespace taut::picture_test {
namespace {

picture::Picture gradient(int width, int height) {
  picture::Picture picture(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int k = 0; k < 3; ++k) picture.at(x, y)[k] = std::uint8_t(7 * x + 13 * y * (k + 1));
  return picture;
}

TEST(Picture, ComesBackFromItsFile) {
  const Folder folder;
  for (const auto& [width, height] : {std::pair(1, 1), {1, 5}, {7, 1}, {63, 41}, {640, 360}}) {
    const picture::Picture picture = gradient(width, height);
    const auto bytes = picture::encode_png(picture);
    const auto file = folder.write("picture.png", std::string(bytes.begin(), bytes.end()));
    const picture::Picture read = picture::read_png(file);
    EXPECT_EQ(read.width, width);
    EXPECT_EQ(read.height, height);
    EXPECT_EQ(read.pixels, picture.pixels) << width << "x" << height;
  }
}

TEST(Picture, ARibbonGetsNarrowerAndFainterAndCountsNoPlaceTwice) {
  picture::Picture picture(100, 40);
  std::ranges::fill(picture.pixels, std::uint8_t{0});
  const std::vector<picture::RibbonPoint> points = {
      {10, 20, 2, 0.2}, {50, 20, 6, 0.6}, {50, 20, 6, 0.6}, {90, 20, 10, 1}};
  picture::ribbon(picture, points, {255, 255, 255});
  const auto value = [&](int x, int y) { return int(picture.at(x, y)[0]); };
  EXPECT_NEAR(value(30, 20), 255 * 0.4, 4);
  EXPECT_NEAR(value(50, 20), 255 * 0.6, 4) << "where pieces meet, once";
  EXPECT_NEAR(value(70, 20), 255 * 0.8, 4);
  EXPECT_EQ(value(30, 24), 0) << "2 px to the side";
  EXPECT_NEAR(value(86, 23), 255 * 0.96, 4) << "5 px";
  EXPECT_EQ(value(86, 30), 0);
}

TEST(Picture, DamageIsNoticed) {
  const Folder folder;
  const auto bytes = picture::encode_png(gradient(63, 41));
  for (std::size_t at = 29; at < bytes.size(); at += 97) {  // from the header's checksum on
    std::string damaged(bytes.begin(), bytes.end());
    damaged[at] = char(damaged[at] ^ 0x10);
    const auto file = folder.write("damaged.png", damaged);
    try {
      EXPECT_NE(picture::read_png(file).pixels, gradient(63, 41).pixels) << at;
    } catch (const std::runtime_error& e) {
      EXPECT_NE(std::string(e.what()).find("damaged.png"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace taut::picture_test
