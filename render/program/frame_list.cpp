#include "render/program/frame_list.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <set>
#include <string_view>

#include "render/program/command.h"

namespace taut::program {
namespace {

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0) return {};
  return value;
}

}  // namespace

std::vector<int> frame_list(const std::optional<std::string>& text, int total) {
  std::set<int> frames;
  if (!text)
    for (int i = 0; i < total; ++i) frames.insert(i);
  std::string_view rest;
  if (text) rest = *text;
  while (!rest.empty()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const std::string_view part = rest.substr(0, comma);
    const std::size_t dash = part.find('-');
    const auto first = whole_number(part.substr(0, dash));
    const auto last = dash == part.npos ? first : whole_number(part.substr(dash + 1));
    if (!first || !last || *last < *first)
      throw Misuse(fmt::format("--frames: '{}' is no frame or range (expected A-B,C)", part));
    if (*last >= total)
      throw Misuse(
          fmt::format("--frames: frame {} is beyond the clip's last, {}", *last, total - 1));
    for (int i = *first; i <= *last; ++i) frames.insert(i);
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  if (frames.empty()) throw Misuse("--frames: names no frame (expected A-B,C)");
  return {frames.begin(), frames.end()};
}

std::pair<int, int> picture_size(const std::string& text) {
  const std::string_view whole = text;
  const std::size_t cross = std::min(whole.find('x'), whole.size() - 1);
  const int width = whole_number(whole.substr(0, cross)).value_or(0);
  const int height = whole_number(whole.substr(cross + 1)).value_or(0);
  if (width == 0 || height == 0)
    throw Misuse(fmt::format("--size: '{}' is no size (expected WxH, such as 1280x720)", text));
  return {width, height};
}

}  // namespace taut::program
