#include "render/picture/text.h"

#include <fmt/format.h>
#include <ft2build.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include FT_FREETYPE_H
#include FT_MODULE_H

namespace taut::picture {
namespace {

constexpr const char* kFolder = "/usr/share/fonts/truetype/";

struct Typeface {
  const char *regular, *bold;  // files in the folder
  const char* package;
};
constexpr Typeface kTypefaces[] = {
    {"dejavu/DejaVuSans.ttf", "dejavu/DejaVuSans-Bold.ttf", "fonts-dejavu-core"},
    {"lato/Lato-Medium.ttf", "lato/Lato-Heavy.ttf", "fonts-lato"}};

/// UTF-8 to code points; a malformed byte becomes U+FFFD.
std::vector<char32_t> code_points(std::string_view text) {
  std::vector<char32_t> points;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t length = lead < 0x80       ? 1
                               : lead >> 5 == 6  ? 2
                               : lead >> 4 == 14 ? 3
                               : lead >> 3 == 30 ? 4
                                                 : 0;
    char32_t point = length == 1 ? lead : lead & (0xffu >> (length + 1));
    bool whole = length > 0 && i + length <= text.size();
    for (std::size_t k = 1; whole && k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      whole = next >> 6 == 2;
      point = point << 6 | (next & 0x3f);
    }
    points.push_back(whole ? point : U'\ufffd');
    i += whole ? length : 1;
  }
  return points;
}

/// Unicode's Default_Ignorable_Code_Point: without ink where a font does not know them.
bool asks_for_no_ink(char32_t point) {
  constexpr std::pair<char32_t, char32_t> kRanges[] = {
      {0xad, 0xad},       {0x34f, 0x34f},    {0x61c, 0x61c},   {0x115f, 0x1160}, {0x17b4, 0x17b5},
      {0x180b, 0x180f},   {0x200b, 0x200f},  {0x202a, 0x202e}, {0x2060, 0x206f}, {0x3164, 0x3164},
      {0xfe00, 0xfe0f},   {0xfeff, 0xfeff},  {0xffa0, 0xffa0}, {0xfff0, 0xfff8}, {0x1bca0, 0x1bca3},
      {0x1d173, 0x1d17a}, {0xe0000, 0xe0fff}};
  return std::ranges::any_of(
      kRanges, [&](const auto& range) { return point >= range.first && point <= range.second; });
}

}  // namespace

struct Font::Face {
  // FreeType calls a font broken where memory runs out inside of one of its tables.
  bool ran_out = false;
  FT_MemoryRec_ memory{this,
                       [](FT_Memory at, long size) {
                         void* block = std::malloc(std::size_t(size));
                         static_cast<Face*>(at->user)->ran_out |= block == nullptr;
                         return block;
                       },
                       [](FT_Memory, void* block) { std::free(block); },
                       [](FT_Memory at, long, long size, void* old) {
                         void* block = std::realloc(old, std::size_t(size));
                         static_cast<Face*>(at->user)->ran_out |= block == nullptr;
                         return block;
                       }};
  FT_Library library = nullptr;
  FT_Face face = nullptr;

  Face() {
    if (FT_New_Library(&memory, &library) != 0) throw std::bad_alloc();
    FT_Add_Default_Modules(library);
  }
  ~Face() { FT_Done_Library(library); }  // and the face
  Face(const Face&) = delete;
  Face& operator=(const Face&) = delete;

  /// Calls `use(glyph slot, x of its origin)` for each character of a line that starts at `x`
  /// (pixels), and returns where the line ends.
  template <typename Use>
  double lay_out(std::string_view text, double size, double x, FT_Int32 flags, Use use) {
    FT_Set_Char_Size(face, 0, FT_F26Dot6(std::lround(size * 64)), 72, 72);
    FT_UInt previous = 0;
    for (const char32_t point : code_points(text)) {
      if (asks_for_no_ink(point)) continue;
      const FT_UInt glyph = FT_Get_Char_Index(face, point == U'\t' ? U' ' : point);
      FT_Vector kern{};
      if (previous && glyph) FT_Get_Kerning(face, previous, glyph, FT_KERNING_UNFITTED, &kern);
      x += double(kern.x) / 64;
      previous = glyph;
      // The origin's fraction of a pixel goes into the outline, so that moving text does not jump.
      FT_Vector shift{FT_Pos((x - std::floor(x)) * 64), 0};
      FT_Set_Transform(face, nullptr, &shift);
      const bool loaded = FT_Load_Glyph(face, glyph, flags) == 0;
      if (ran_out) throw std::bad_alloc();
      if (!loaded) continue;
      use(*face->glyph, int(std::floor(x)));
      x += double(face->glyph->linearHoriAdvance) / 65536;
    }
    return x;
  }
};

Font::Font(Weight weight, Family family) : face_(std::make_unique<Face>()) {
  const Typeface& typeface = kTypefaces[std::size_t(family)];
  const std::string file =
      fmt::format("{}{}", kFolder, weight == Weight::bold ? typeface.bold : typeface.regular);
  const bool opened = FT_New_Face(face_->library, file.c_str(), 0, &face_->face) == 0;
  if (face_->ran_out) throw std::bad_alloc();
  if (opened) return;
  throw std::runtime_error(fmt::format("{}: missing (package {})", file, typeface.package));
}

Font::~Font() = default;

std::vector<char32_t> Font::missing(std::string_view text) const {
  std::vector<char32_t> found;
  for (const char32_t point : code_points(text)) {
    if (point == U'\n' || point == U'\t' || asks_for_no_ink(point)) continue;
    if (FT_Get_Char_Index(face_->face, point) != 0) continue;
    if (std::ranges::find(found, point) == found.end()) found.push_back(point);
  }
  return found;
}

double Font::width(std::string_view text, double size) {
  return face_->lay_out(text, size, 0, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP,
                        [](const FT_GlyphSlotRec&, int) {});
}

void Font::draw(Picture& picture, std::string_view text, double x, double y, double size, Rgb color,
                double opacity) {
  const int line = int(std::lround(y));
  face_->lay_out(text, size, x, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP | FT_LOAD_RENDER,
                 [&](const FT_GlyphSlotRec& glyph, int origin) {
                   const int left = origin + glyph.bitmap_left, top = line - glyph.bitmap_top;
                   for (int row = 0; row < int(glyph.bitmap.rows); ++row)
                     for (int column = 0; column < int(glyph.bitmap.width); ++column) {
                       const int px = left + column, py = top + row;
                       if (px < 0 || py < 0 || px >= picture.width || py >= picture.height)
                         continue;
                       const double cover =
                           opacity * glyph.bitmap.buffer[row * glyph.bitmap.pitch + column] / 255;
                       std::uint8_t* pixel = picture.at(px, py);
                       for (std::size_t k = 0; k < 3; ++k)
                         pixel[k] = std::uint8_t(
                             std::lround(pixel[k] + cover * (double(color[k]) - pixel[k])));
                     }
                 });
}

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
