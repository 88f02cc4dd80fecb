#include "sim/motion/printable.h"

#include <cstddef>

namespace taut {
namespace {

struct Character {
  std::size_t bytes = 1;
  char32_t point = 0;
  bool is_valid = false;
};

/// The first character of a text that is not empty.
Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  const std::size_t bytes = lead < 0x80                   ? 1
                            : lead >= 0xc2 && lead < 0xe0 ? 2
                            : lead >= 0xe0 && lead < 0xf0 ? 3
                            : lead >= 0xf0 && lead < 0xf5 ? 4
                                                          : 0;
  if (bytes == 0 || bytes > text.size()) return {};
  char32_t point = bytes == 1 ? lead : lead & (0xffu >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if (byte(i) >> 6 != 2) return {};
    point = point << 6 | (byte(i) & 0x3fu);
  }
  constexpr char32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = point >= 0xd800 && point < 0xe000;
  if (point < kLeast[bytes] || is_surrogate || point > 0x10ffff) return {};
  return {bytes, point, true};
}

bool is_shown(char32_t point) {
  const bool is_control = point < 0x20 || (point >= 0x7f && point < 0xa0);
  const bool turns = point == 0x200e || point == 0x200f || (point >= 0x2028 && point < 0x202f) ||
                     (point >= 0x2066 && point < 0x206a);
  return !is_control && !turns;
}

std::string escaped(std::string_view text, bool keeps_newlines) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Character next = first_of(text);
    const std::string_view bytes = text.substr(0, next.bytes);
    text.remove_prefix(next.bytes);
    if (next.is_valid && (is_shown(next.point) || (keeps_newlines && next.point == '\n'))) {
      shown += bytes;
    } else if (next.is_valid && next.point == '\n') {
      shown += "\\n";
    } else if (next.is_valid && next.point == '\t') {
      shown += "\\t";
    } else {
      for (const char c : bytes) {
        const auto byte = static_cast<unsigned char>(c);
        shown += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
      }
    }
  }
  return shown;
}

}  // namespace

std::string printable(std::string_view text) {
  return escaped(text, false);
}

std::string printable_lines(std::string_view text) {
  return escaped(text, true);
}

}  // namespace taut
