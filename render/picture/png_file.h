// PNG files with more than opaque pixels.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/picture/picture.h"

namespace taut::picture {

struct PngExtras {
  bool opacity = false;  // the fourth bytes are opacity; colours are not multiplied by it
  std::vector<std::pair<std::string, std::string>> texts = {};  // keywords and UTF-8 texts
};

/// The picture as a PNG file's bytes, RGB or RGBA, the texts in front of the pixels.
std::vector<std::uint8_t> encode_png(const Picture& picture, const PngExtras& extras);

}  // namespace taut::picture
