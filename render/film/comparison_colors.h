// Colours of a comparison's text and shapes.
#pragma once

#include <cstdint>

#include "render/picture/text.h"

namespace taut::film {

inline constexpr picture::Rgb kInk = {32, 34, 38}, kGrey = {110, 112, 116},
                              kPaper = {255, 255, 255};

/// Of 0xrrggbb.
inline picture::Rgb rgb(std::uint32_t color) {
  return {std::uint8_t(color >> 16), std::uint8_t(color >> 8), std::uint8_t(color)};
}

}  // namespace taut::film
