// A picture in memory, and PNG files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace taut::picture {

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
