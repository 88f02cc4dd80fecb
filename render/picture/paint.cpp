#include "render/picture/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

namespace taut::picture {

namespace {

/// A colour over a pixel, from all values that the pixel can have.
class Blend {
 public:
  Blend(Rgb color, double opacity) {
    for (std::size_t k = 0; k < 3; ++k)
      for (int value = 0; value < 256; ++value)
        result_[k][std::size_t(value)] =
            std::uint8_t(std::lround(std::lerp(double(value), double(color[k]), opacity)));
  }
  void operator()(std::uint8_t* pixel) const {
    for (std::size_t k = 0; k < 3; ++k) pixel[k] = result_[k][pixel[k]];
  }

 private:
  std::array<std::array<std::uint8_t, 256>, 3> result_;
};

}  // namespace

void fill(Picture& picture, const Rect& rect, Rgb color, double opacity) {
  const Rect part = intersection(rect, {0, 0, picture.width, picture.height});
  const Blend blend(color, opacity);
  for (int y = part.y; y < part.top(); ++y)
    for (int x = part.x; x < part.right(); ++x) blend(picture.at(x, y));
}

void fill_softly(Picture& picture, const Rect& rect, Rgb color, double opacity, double feather) {
  const int margin = int(std::ceil(feather));
  const Rect part = intersection(
      {rect.x - margin, rect.y - margin, rect.width + 2 * margin, rect.height + 2 * margin},
      {0, 0, picture.width, picture.height});
  const auto outside = [](int at, int from, int until) {
    return std::max({0, from - at, at - (until - 1)});
  };
  const Blend inside(color, opacity);
  for (int y = part.y; y < part.top(); ++y)
    for (int x = part.x; x < part.right(); ++x) {
      if (x >= rect.x && x < rect.right() && y >= rect.y && y < rect.top()) {
        inside(picture.at(x, y));
        continue;
      }
      const double off =
          std::hypot(outside(x, rect.x, rect.right()), outside(y, rect.y, rect.top()));
      const double t = std::max(0.0, 1 - off / feather), cover = opacity * t * t * (3 - 2 * t);
      for (std::size_t k = 0; k < 3; ++k) {
        std::uint8_t& value = picture.at(x, y)[k];
        value = std::uint8_t(std::lround(std::lerp(double(value), double(color[k]), cover)));
      }
    }
}

void paste(const Picture& from, Picture& to, int x, int y) {
  for (int row = 0; row < from.height; ++row)
    std::memcpy(to.at(x, y + row), from.at(0, row), std::size_t(from.width) * 4);
}

Picture shrunk(const Picture& picture, int factor) {
  Picture small(picture.width / factor, picture.height / factor);
  const int area = factor * factor;
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (int k = 0; k < 3; ++k) {
        int sum = 0;
        for (int v = 0; v < factor; ++v)
          for (int u = 0; u < factor; ++u) sum += picture.at(x * factor + u, y * factor + v)[k];
        small.at(x, y)[k] = std::uint8_t((sum + area / 2) / area);
      }
  return small;
}

std::vector<std::string> wrapped(Font& font, const std::string& text, double size, double width) {
  std::vector<std::string> lines;
  std::istringstream words(text);
  words.exceptions(std::ios::badbit);  // or running out of memory would end the text
  for (std::string word; words >> word;) {
    if (!lines.empty() && font.width(lines.back() + " " + word, size) <= width)
      lines.back() += " " + word;
    else
      lines.push_back(word);
  }
  return lines;
}

}  // namespace taut::picture
