#include "render/golden/picture_difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace taut::golden {
namespace {

int distance(const std::uint8_t* a, const std::uint8_t* b) {
  int largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(int(a[k]) - int(b[k])));
  return largest;
}

/// The least distance of the pixel of `a` from those of `b` within one of it; no less than 8 is
/// looked for.
int distance_from_nearest(const picture::Picture& a, const picture::Picture& b, int x, int y) {
  int nearest = distance(a.at(x, y), b.at(x, y));
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, b.height - 1) && nearest > 8; ++v)
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, b.width - 1); ++u)
      nearest = std::min(nearest, distance(a.at(x, y), b.at(u, v)));
  return nearest;
}

}  // namespace

PictureDifference difference(const picture::Picture& actual, const picture::Picture& golden) {
  if (actual.width != golden.width || actual.height != golden.height)
    throw std::invalid_argument(fmt::format("pictures of {}x{} and {}x{} cannot be compared",
                                            actual.width, actual.height, golden.width,
                                            golden.height));
  PictureDifference result;
  std::array<double, 3> sums{};
  std::size_t far = 0, far_from_all = 0;
  for (int y = 0; y < golden.height; ++y)
    for (int x = 0; x < golden.width; ++x) {
      const std::uint8_t *a = actual.at(x, y), *g = golden.at(x, y);
      for (std::size_t k = 0; k < 3; ++k) sums[k] += double(a[k]) - double(g[k]);
      const int here = distance(a, g);
      result.largest = std::max(result.largest, here);
      far += here > 2;
      far_from_all += here > 8 && (distance_from_nearest(actual, golden, x, y) > 8 ||
                                   distance_from_nearest(golden, actual, x, y) > 8);
    }
  const double pixels = double(golden.width) * golden.height;
  result.above_2 = double(far) / pixels;
  result.near_above_8 = double(far_from_all) / pixels;
  for (const double sum : sums)
    result.mean_shift = std::max(result.mean_shift, std::abs(sum) / pixels);
  return result;
}

bool same_rendering(const PictureDifference& d) {
  return d.above_2 <= 1e-4 && d.largest <= 16 && d.mean_shift <= 0.3;
}

bool same_picture(const PictureDifference& d) {
  return d.near_above_8 <= 1e-3;
}

}  // namespace taut::golden
