#include "render/film/caption.h"

#include <algorithm>
#include <cmath>

#include "render/picture/paint.h"

namespace taut::film {
namespace {

constexpr double kFade = 0.2;    // s
constexpr double kDim = 0.45;    // opacity of a list's neighbouring lines
constexpr double kShade = 0.34;  // darkness behind the lines, soft at its edges
constexpr double kLeading = 1.55;

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

/// Rises from 0 to 1 with x, and stands still at both.
double eased(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// Which line of a list stands in the middle at `time`, with a fraction on the way to the next.
double rolled(std::span<const scenes::Caption> list, double time) {
  double at = 0;
  for (std::size_t i = 1; i < list.size(); ++i) at += eased((time - list[i].from) / kFade + 0.5);
  return at;
}

/// How much shows of a line that is so many lines away from the middle.
double nearness(double lines) {
  return lines < 1 ? std::lerp(1, kDim, eased(lines)) : kDim * (1 - eased(2 * (lines - 1)));
}

struct Lines {
  picture::Picture& picture;
  picture::Font& font;
  double size = std::max(0.028 * picture.height, 9.0);
  double x = 0.05 * picture.width, y = 0.88 * picture.height;
  double column = 0, rest = 0;  // widths, px: of labels with the gap behind them, of what follows

  /// Makes room for a line.
  void measure(std::string_view text) {
    const auto [label, words] = parted(text);
    if (!label.empty()) column = std::max(column, font.width(label, size) + 0.7 * size);
    rest = std::max(rest, font.width(words, size));
  }

  /// Darkens the picture behind so many lines on each side of the middle.
  void darken(int beside, double opacity) {
    const double height = (2 * beside * kLeading + 1) * size;
    picture::fill_softly(
        picture, {int(x), int(y - 0.35 * size - height / 2), int(column + rest), int(height)},
        {12, 10, 8}, kShade * opacity, 5 * size);
  }

  /// `down` lines below the middle.
  void draw(std::string_view text, double down, double opacity) {
    const double shadow = std::max(1.0, size / 18), line = y + down * kLeading * size;
    const auto [label, words] = parted(text);
    for (const auto& [part, left] : {std::pair(label, x), {words, x + column}}) {
      font.draw(picture, part, left + shadow, line + shadow, size, {0, 0, 0}, 0.55 * opacity);
      font.draw(picture, part, left, line, size, {248, 245, 238}, 0.97 * opacity);
    }
  }
};

}  // namespace

void draw_captions(picture::Picture& picture, picture::Font& font,
                   std::span<const scenes::Caption> captions, double time) {
  for (auto first = captions.begin(); first != captions.end();) {
    const auto last = std::find_if(first + 1, captions.end(), [&](const scenes::Caption& caption) {
      return first->list.empty() || caption.list != first->list;
    });
    const std::span<const scenes::Caption> list(first, last);
    first = last;
    double until = list.front().until;
    for (const scenes::Caption& caption : list) until = std::max(until, caption.until);
    if (list.size() > 1) until += kFade;  // its last line is read to the end
    const double opacity = shown(list.front().from, until, time);
    if (opacity <= 0) continue;
    Lines lines{picture, font};
    for (const scenes::Caption& caption : list) lines.measure(caption.text);
    lines.darken(list.size() > 1 ? 1 : 0, opacity);
    const double middle = rolled(list, time);
    for (std::size_t i = 0; i < list.size(); ++i) {
      const double down = double(i) - middle;
      if (const double near = nearness(std::abs(down)); near > 0)
        lines.draw(list[i].text, down, opacity * near);
    }
  }
}

void draw_note(picture::Picture& picture, picture::Font& font, std::string_view text) {
  Lines lines{picture, font, std::max(0.018 * picture.height, 9.0)};
  lines.y = 0.05 * picture.height + lines.size;
  lines.measure(text);
  lines.darken(0, 1);
  lines.draw(text, 0, 1);
}

}  // namespace taut::film
