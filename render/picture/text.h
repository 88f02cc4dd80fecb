// Text, flat shapes and lines on a picture.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/picture/picture.h"

namespace taut::picture {

using Rgb = std::array<std::uint8_t, 3>;  // sRGB

/// A typeface. Text is UTF-8; characters that the font lacks become its box, a tab becomes a space,
/// and characters that ask for no ink (zero-width spaces, soft hyphens, variation selectors) none.
class Font {
 public:
  enum class Weight { regular, bold };
  enum class Family { dejavu, lato };  // for charts and tables; for films
  /// Opens it where Debian keeps it. Throws std::runtime_error where it is missing.
  explicit Font(Weight weight = Weight::regular, Family family = Family::dejavu);
  ~Font();
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;

  /// How wide a line of `text` is in letters of `size` pixels.
  double width(std::string_view text, double size);
  /// The characters of `text` that the font lacks, each once, in their order; newlines and tabs are
  /// not looked for.
  std::vector<char32_t> missing(std::string_view text) const;
  /// Blends a line over the picture, its base line starting at (x, y) pixels from the upper left;
  /// `opacity` from 0 to 1. Parts outside are left out.
  void draw(Picture& picture, std::string_view text, double x, double y, double size, Rgb color,
            double opacity = 1);

 private:
  struct Face;
  std::unique_ptr<Face> face_;
};

// Flat shapes and lines of text on finished pictures.

/// Blends a colour over a rectangle (from the upper left corner), as far as it lies inside.
void fill(Picture& picture, const Rect& rect, Rgb color, double opacity = 1);

/// Blends a line through points (px from the upper left corner) over the picture, its edges and its
/// joints smooth; a point that is not finite breaks it.
void stroke(Picture& picture, std::span<const std::array<double, 2>> points, double width,
            Rgb color, double opacity = 1);

/// A point of a ribbon: px from the upper left corner, px across, and how much of it covers.
struct RibbonPoint {
  double x, y, width, opacity;
};
/// Blends a line through points over the picture as stroke() does, its width and its opacity even
/// between them; a point that is not finite breaks it.
void ribbon(Picture& picture, std::span<const RibbonPoint> points, Rgb color);

/// Blends a colour over the picture softly round a line of text, at most `opacity` of it and
/// nothing farther than the letters' size away: pale letters over it are read on any ground.
void draw_shadow(Picture& picture, Font& font, std::string_view text, double x, double y,
                 double size, Rgb color, double opacity);

/// Copies a picture into another, its upper left corner at (x, y); it must fit.
void paste(const Picture& from, Picture& to, int x, int y);

/// Each `factor` x `factor` pixels averaged into one.
Picture shrunk(const Picture& picture, int factor);

/// Text broken into lines no wider than `width` pixels where its words allow.
std::vector<std::string> wrapped(Font& font, const std::string& text, double size, double width);

}  // namespace taut::picture
