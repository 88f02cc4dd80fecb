// A picture in memory, rectangles of its pixels, and PNG files.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace taut::picture {

// Rectangles of pixels.

/// A rectangle of pixels from the lower left corner.
struct Rect {
  int x = 0, y = 0, width = 0, height = 0;

  int right() const { return x + width; }
  int top() const { return y + height; }
  bool empty() const { return width <= 0 || height <= 0; }
};

inline Rect intersection(const Rect& a, const Rect& b) {
  const int x = std::max(a.x, b.x), y = std::max(a.y, b.y);
  return {x, y, std::max(std::min(a.right(), b.right()) - x, 0),
          std::max(std::min(a.top(), b.top()) - y, 0)};
}

/// The smallest rectangle around both.
inline Rect hull(const Rect& a, const Rect& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  const int x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.right(), b.right()) - x, std::max(a.top(), b.top()) - y};
}

/// Rectangles that do not overlap: those that would become one.
class RectSet {
 public:
  void add(Rect rect) {
    if (rect.empty()) return;
    for (std::size_t i = 0; i < rects_.size();) {
      if (intersection(rects_[i], rect).empty()) {
        ++i;
        continue;
      }
      rect = hull(rects_[i], rect);
      rects_.erase(rects_.begin() + std::ptrdiff_t(i));
      i = 0;
    }
    rects_.push_back(rect);
  }
  void clear() { rects_.clear(); }

  auto begin() const { return rects_.begin(); }
  auto end() const { return rects_.end(); }

 private:
  std::vector<Rect> rects_;
};

/// 8-bit sRGB pixels, four bytes each (red, green, blue, unused), the top row first.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  Picture() = default;
  Picture(int w, int h)
      : width(w), height(h), pixels(std::size_t(w) * std::size_t(h) * 4, std::uint8_t(255)) {}
  std::uint8_t* at(int x, int y) {
    return &pixels[(std::size_t(y) * std::size_t(width) + std::size_t(x)) * 4];
  }
  const std::uint8_t* at(int x, int y) const { return const_cast<Picture*>(this)->at(x, y); }
};

/// The picture as a PNG file's bytes, RGB; packed for speed rather than size.
std::vector<std::uint8_t> encode_png(const Picture& picture);

/// The content of a PNG file beside opaque pixels.
struct PngExtras {
  bool opacity = false;  // the fourth bytes are opacity; colours are not multiplied by it
  std::vector<std::pair<std::string, std::string>> texts = {};  // keywords and UTF-8 texts
};

/// The picture as a PNG file's bytes, RGB or RGBA, the texts in front of the pixels.
std::vector<std::uint8_t> encode_png(const Picture& picture, const PngExtras& extras);

/// Reads back a PNG file. Throws BadAsset.
Picture read_png(const std::filesystem::path& file);
/// The same from a PNG file's bytes, which messages call `source`.
Picture decode_png(std::span<const std::uint8_t> bytes,
                   const std::string& source = "a PNG picture");

}  // namespace taut::picture
