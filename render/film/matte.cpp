#include "render/film/matte.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/picture/text.h"

namespace taut::film {
namespace {

double linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

double encoded(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

std::uint8_t byte(double share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

/// Samples of a pixel are averaged as light, so shares of the background are shares of light.
const std::array<double, 256>& light_of_bytes() {
  static const auto table = [] {
    std::array<double, 256> list{};
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = linear(static_cast<double>(i) / 255);
    return list;
  }();
  return table;
}

}  // namespace

picture::Picture matte(const picture::Picture& on_black, const picture::Picture& on_white) {
  const auto& light = light_of_bytes();
  constexpr double kNothing = 3.0 / 255;  // of opacity: within the pictures' rounding
  picture::Picture result(on_black.width, on_black.height);
  for (std::size_t i = 0; i < result.pixels.size(); i += 4) {
    double through = 0;  // the share of the background that is seen
    for (std::size_t k = 0; k < 3; ++k)
      through += (light[on_white.pixels[i + k]] - light[on_black.pixels[i + k]]) / 3;
    const double opacity = 1 - std::clamp(through, 0.0, 1.0);
    const bool nothing = opacity<kNothing, solid = opacity> 1 - kNothing;
    for (std::size_t k = 0; k < 3; ++k) {
      result.pixels[i + k] = nothing ? std::uint8_t(0)
                             : solid ? on_black.pixels[i + k]
                                     : byte(encoded(light[on_black.pixels[i + k]] / opacity));
    }
    result.pixels[i + 3] = nothing ? std::uint8_t(0) : solid ? std::uint8_t(255) : byte(opacity);
  }
  return result;
}

picture::Picture mean(std::span<const picture::Picture> pictures) {
  if (pictures.size() == 1) return pictures[0];
  const auto& light = light_of_bytes();
  picture::Picture result(pictures[0].width, pictures[0].height);
  for (std::size_t i = 0; i < result.pixels.size(); ++i) {
    if (i % 4 == 3) continue;
    double sum = 0;
    for (const picture::Picture& one : pictures) sum += light[one.pixels[i]];
    result.pixels[i] = byte(encoded(sum / double(pictures.size())));
  }
  return result;
}

picture::Picture contact_sheet(std::span<const picture::Picture> pictures, int columns) {
  const int width = pictures[0].width, height = pictures[0].height;
  const int rows = (int(pictures.size()) + columns - 1) / columns;
  picture::Picture sheet(width * columns, height * rows);
  for (int i = 0; i < int(pictures.size()); ++i)
    picture::paste(pictures[std::size_t(i)], sheet, i % columns * width, i / columns * height);
  return sheet;
}

}  // namespace taut::film
