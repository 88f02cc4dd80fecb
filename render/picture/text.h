// Lines of text on a picture, with a real font.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
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

}  // namespace taut::picture
