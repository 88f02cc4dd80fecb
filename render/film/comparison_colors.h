// Colours of a comparison's text and shapes.
#pragma once

#include <cstdint>

#include "render/film/verdict.h"
#include "render/picture/text.h"

namespace taut::film {

inline constexpr picture::Rgb kInk = {32, 34, 38}, kGrey = {96, 98, 102}, kPaper = {255, 255, 255},
                              kRight = {24, 122, 62}, kOff = {190, 95, 10}, kBroken = {176, 32, 40};

/// Of 0xrrggbb.
inline picture::Rgb rgb(std::uint32_t color) {
  return {std::uint8_t(color >> 16), std::uint8_t(color >> 8), std::uint8_t(color)};
}

inline picture::Rgb rgb(Verdict::Grade grade) {
  switch (grade) {
    case Verdict::Grade::kept:
      return kRight;
    case Verdict::Grade::off:
      return kOff;
    case Verdict::Grade::broken:
      return kBroken;
    case Verdict::Grade::none:
      break;
  }
  return kGrey;
}

}  // namespace taut::film
