#include "render/film/caption.h"

#include <algorithm>

#include "render/picture/paint.h"

namespace taut::film {
namespace {

constexpr double kCaptionFade = 0.15;  // s of the clip
constexpr double kLeastShown = 0.45;   // s of the clip, or nobody reads it
constexpr double kSafe = 0.05;   // of the picture on each side, outside of the title-safe part
constexpr double kShadow = 0.9;  // opacity of the letters' shadow
constexpr double kLabel = 0.8;   // opacity of labels, of the text's
constexpr picture::Rgb kLetters{248, 245, 238}, kAround{12, 10, 8};

/// How much of a caption shows.
double shown(const scenes::Caption& caption, const Playing& playing) {
  const double from = std::max(caption.from, playing.from);
  const double until = std::min(caption.until, playing.until);
  if (playing.time < from || playing.time >= until) return 0;
  if (until - from < (kLeastShown - 1e-9) * playing.rate) return 0;
  double opacity = 1;
  if (caption.from > playing.from)
    opacity = std::min(opacity, (playing.time - from + 1e-3) / playing.rate / kCaptionFade);
  if (caption.until < playing.until)
    opacity = std::min(opacity, (until - playing.time) / playing.rate / kCaptionFade);
  return opacity;
}

/// A line's label, which stands in a column of its own, and the rest; a tab parts them.
std::pair<std::string_view, std::string_view> parted(std::string_view text) {
  const auto tab = text.find('\t');
  if (tab == text.npos) return {{}, text};
  return {text.substr(0, tab), text.substr(tab + 1)};
}

struct Line {
  picture::Picture& picture;
  picture::Font& font;
  double size, y;     // px: of the letters, of the line that they stand on
  double column = 0;  // px: of labels with the gap behind them
  double x = kSafe * picture.width;

  /// Makes room for its label.
  void measure(std::string_view text) {
    if (const auto label = parted(text).first; !label.empty())
      column = std::max(column, font.width(label, size) + 0.7 * size);
  }

  void draw(std::string_view text, double opacity) {
    const auto [label, words] = parted(text);
    for (const auto& [part, left] : {std::pair(label, x), {words, x + column}})
      picture::draw_shadow(picture, font, part, left, y, size, kAround, kShadow * opacity);
    font.draw(picture, label, x, y, size, kLetters, kLabel * opacity);
    font.draw(picture, words, x + column, y, size, kLetters, opacity);
  }
};

}  // namespace

void draw_captions(picture::Picture& picture, picture::Font& font,
                   std::span<const scenes::Caption> captions, const Playing& playing) {
  const double size = std::max(0.032 * picture.height, 9.0);
  for (const scenes::Caption& caption : captions) {
    const double opacity = shown(caption, playing);
    if (opacity <= 0) continue;
    Line line{picture, font, size, (1 - kSafe) * picture.height - 0.3 * size};
    line.measure(caption.text);
    for (const scenes::Caption& other : captions)
      if (!caption.list.empty() && other.list == caption.list) line.measure(other.text);
    line.draw(caption.text, opacity);
  }
}

void draw_note(picture::Picture& picture, picture::Font& font, std::string_view text) {
  const double size = std::max(0.018 * picture.height, 9.0);
  Line{picture, font, size, kSafe * picture.height + size}.draw(text, 1);
}

}  // namespace taut::film
