#include "render/film/caption.h"

#include <algorithm>
#include <cmath>

#include "render/picture/paint.h"

namespace taut {
namespace {

constexpr double kFade = 0.2;    // s
constexpr double kDim = 0.6;     // opacity of a list's lines whose time it is not
constexpr double kPanel = 0.38;  // darkness behind the lines, soft at its edges
constexpr double kLeading = 1.5;

/// How much of something shows that fades in and out between two times.
double shown(double from, double until, double time) {
  if (time < from || time >= until) return 0;
  return std::min({1.0, (time - from + 1e-3) / kFade, (until - time) / kFade});
}

/// A line's label, which stands in a column of its own, and the rest; a tab parts them.
std::pair<std::string_view, std::string_view> parted(std::string_view text) {
  const auto tab = text.find('\t');
  if (tab == text.npos) return {{}, text};
  return {text.substr(0, tab), text.substr(tab + 1)};
}

struct Lines {
  Picture& picture;
  Font& font;
  double size = std::max(0.024 * picture.height, 9.0);
  double x = 0.04 * picture.width, y = 0.93 * picture.height;
  double column = 0, rest = 0;  // widths, px: of labels with the gap behind them, of what follows

  /// Makes room for a line.
  void measure(std::string_view text) {
    const auto [label, words] = parted(text);
    if (!label.empty()) column = std::max(column, font.width(label, size) + 0.7 * size);
    rest = std::max(rest, font.width(words, size));
  }

  /// Darkens the picture behind the lowest `count` lines.
  void darken(int count, double opacity) {
    const double margin = 0.6 * size, height = ((count - 1) * kLeading + 1) * size;
    fill_softly(
        picture,
        {int(x - margin), int(y - height), int(column + rest + 2 * margin), int(height + margin)},
        {16, 13, 10}, kPanel * opacity, 2.5 * size);
  }

  /// `up` lines above the lowest.
  void draw(std::string_view text, int up, double opacity) {
    const double shadow = std::max(1.0, size / 18), line = y - up * kLeading * size;
    const auto [label, words] = parted(text);
    for (const auto& [part, left] : {std::pair(label, x), {words, x + column}}) {
      font.draw(picture, part, left + shadow, line + shadow, size, {0, 0, 0}, 0.55 * opacity);
      font.draw(picture, part, left, line, size, {248, 245, 238}, 0.95 * opacity);
    }
  }
};

}  // namespace

void draw_captions(Picture& picture, Font& font, std::span<const Caption> captions, double time) {
  for (auto first = captions.begin(); first != captions.end();) {
    const auto last = std::find_if(first + 1, captions.end(), [&](const Caption& caption) {
      return first->list.empty() || caption.list != first->list;
    });
    double until = first->until;
    for (auto caption = first; caption != last; ++caption) until = std::max(until, caption->until);
    if (!first->list.empty()) until += kFade;  // its last line is read to the end
    const double opacity = shown(first->from, until, time);
    auto up = static_cast<int>(last - first);
    Lines lines{picture, font};
    if (opacity > 0) {
      for (auto caption = first; caption != last; ++caption) lines.measure(caption->text);
      lines.darken(up, opacity);
    }
    for (; first != last; ++first) {
      const bool now = first->list.empty() || (time >= first->from && time < first->until);
      --up;
      if (opacity > 0) lines.draw(first->text, up, opacity * (now ? 1 : kDim));
    }
  }
}

void draw_note(Picture& picture, Font& font, std::string_view text) {
  Lines lines{picture, font, std::max(0.018 * picture.height, 9.0)};
  lines.y = 0.05 * picture.height + lines.size;
  lines.measure(text);
  lines.darken(1, 1);
  lines.draw(text, 0, 1);
}

}  // namespace taut
