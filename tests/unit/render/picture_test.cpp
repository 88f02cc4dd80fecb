// PNG files of our own making, read back by libpng.
#include "render/picture/picture.h"

#include <gtest/gtest.h>

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
