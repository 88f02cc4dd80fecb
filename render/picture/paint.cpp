#include "render/picture/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>
#include <utility>

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

/// Each number of `lines` lines of so many becomes the mean of those at most `radius` away in its
/// line, which ends in zeros; `step` and `stride` lead to the next number, and to the next line.
void average(std::vector<float>& numbers, int length, int lines, int step, int stride, int radius) {
  const std::vector<float> before = numbers;
  for (int l = 0; l < lines; ++l) {
    const auto at = [&](int i) { return std::size_t(l * stride + i * step); };
    float sum = 0;
    for (int i = 0; i < std::min(radius, length); ++i) sum += before[at(i)];
    for (int i = 0; i < length; ++i) {
      if (i + radius < length) sum += before[at(i + radius)];
      if (i > radius) sum -= before[at(i - radius - 1)];
      numbers[at(i)] = std::max(sum, 0.0f) / float(2 * radius + 1);
    }
  }
}

}  // namespace

void fill(Picture& picture, const Rect& rect, Rgb color, double opacity) {
  const Rect part = intersection(rect, {0, 0, picture.width, picture.height});
  const Blend blend(color, opacity);
  for (int y = part.y; y < part.top(); ++y)
    for (int x = part.x; x < part.right(); ++x) blend(picture.at(x, y));
}

void ribbon(Picture& picture, std::span<const RibbonPoint> points, Rgb color) {
  const auto is_finite = [](const RibbonPoint& p) {
    return std::isfinite(p.x) && std::isfinite(p.y);
  };
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9}, widest = 0;
  for (const RibbonPoint& p : points) {
    if (!is_finite(p)) continue;
    widest = std::max(widest, p.width);
    for (const auto& [k, value] : {std::pair(0, p.x), {1, p.y}}) {
      low[k] = std::min(low[k], value);
      high[k] = std::max(high[k], value);
    }
  }
  const double reach = widest / 2 + 1;
  const auto whole = [](double value, int most) {
    return int(std::clamp(value, 0.0, double(most)));
  };
  const int left = whole(low[0] - reach, picture.width),
            right = whole(high[0] + reach + 1, picture.width),
            top = whole(low[1] - reach, picture.height),
            bottom = whole(high[1] + reach + 1, picture.height);
  if (left >= right || top >= bottom) return;
  // The share of each pixel that any part of the line covers: where parts meet, none counts twice.
  std::vector<float> cover(std::size_t(right - left) * std::size_t(bottom - top));
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const RibbonPoint &a = points[i], &b = points[i + 1];
    if (!is_finite(a) || !is_finite(b)) continue;
    const double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
    const int x0 = std::max(whole(std::min(a.x, b.x) - reach, picture.width), left),
              x1 = std::min(whole(std::max(a.x, b.x) + reach + 1, picture.width), right),
              y0 = std::max(whole(std::min(a.y, b.y) - reach, picture.height), top),
              y1 = std::min(whole(std::max(a.y, b.y) + reach + 1, picture.height), bottom);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        const double px = x + 0.5 - a.x, py = y + 0.5 - a.y;
        const double t = square > 0 ? std::clamp((px * dx + py * dy) / square, 0.0, 1.0) : 0;
        const double width = std::lerp(a.width, b.width, t);
        const double share = width / 2 + 0.5 - std::hypot(px - t * dx, py - t * dy);
        float& there =
            cover[std::size_t(y - top) * std::size_t(right - left) + std::size_t(x - left)];
        there = std::max(there, float(std::lerp(a.opacity, b.opacity, t) *
                                      std::clamp(share, 0.0, std::min(width, 1.0))));
      }
  }
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) {
      const float there =
          cover[std::size_t(y - top) * std::size_t(right - left) + std::size_t(x - left)];
      if (there <= 0) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        std::uint8_t& value = picture.at(x, y)[k];
        value =
            std::uint8_t(std::lround(std::lerp(double(value), double(color[k]), double(there))));
      }
    }
}

void stroke(Picture& picture, std::span<const std::array<double, 2>> points, double width,
            Rgb color, double opacity) {
  std::vector<RibbonPoint> even;
  for (const auto& [x, y] : points) even.push_back({x, y, width, opacity});
  ribbon(picture, even, color);
}

void draw_shadow(Picture& picture, Font& font, std::string_view text, double x, double y,
                 double size, Rgb color, double opacity) {
  // Three means over a box are nearly a bell.
  const int radius = std::max(int(std::lround(0.2 * size)), 1), margin = 3 * radius;
  const int left = int(std::floor(x)) - margin, top = int(std::floor(y - size)) - margin;
  Picture letters(int(std::ceil(font.width(text, size))) + 2 * margin + 1,
                  int(std::ceil(1.3 * size)) + 2 * margin + 1);
  std::ranges::fill(letters.pixels, std::uint8_t{0});
  font.draw(letters, text, x - left, y - top, size, {255, 255, 255});
  std::vector<float> cover(std::size_t(letters.width) * std::size_t(letters.height));
  for (std::size_t i = 0; i < cover.size(); ++i) cover[i] = float(letters.pixels[4 * i]) / 255;
  for (int pass = 0; pass < 3; ++pass) {
    average(cover, letters.width, letters.height, 1, letters.width, radius);
    average(cover, letters.height, letters.width, letters.width, 1, radius);
  }
  const Rect part = intersection({left, top, letters.width, letters.height},
                                 {0, 0, picture.width, picture.height});
  for (int row = part.y; row < part.top(); ++row)
    for (int column = part.x; column < part.right(); ++column) {
      const float there =
          cover[std::size_t(row - top) * std::size_t(letters.width) + std::size_t(column - left)];
      // Letters cover less than half of their surroundings.
      const double share = opacity * std::min(3 * double(there), 1.0);
      for (std::size_t k = 0; k < 3; ++k) {
        std::uint8_t& value = picture.at(column, row)[k];
        value = std::uint8_t(std::lround(std::lerp(double(value), double(color[k]), share)));
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
