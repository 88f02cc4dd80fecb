// Rectangles of pixels.
#pragma once

#include <algorithm>
#include <vector>

namespace taut::picture {

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

}  // namespace taut::picture
