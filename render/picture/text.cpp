#include "render/picture/text.h"

#include <fmt/format.h>
#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_MODULE_H

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

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

}  // namespace taut::picture
