#include "render/film/caption.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "render/picture/text.h"

namespace taut::film {
namespace {

constexpr double kCaptionFade = 0.15;  // s of the clip
constexpr double kLeastShown = 0.45;   // s of the clip, or nobody reads it
constexpr double kSafe = 0.05;    // of the picture on each side, outside of the title-safe part
constexpr double kShadow = 0.9;   // opacity of the letters' shadow
constexpr double kLeading = 1.3;  // from line to line, of the letters' size
constexpr double kLabel = 0.8;    // opacity of labels, of the text's
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

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  for (bool more = true; more;) {
    const auto end = text.find('\n');
    more = end != text.npos;
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back(line);
    if (more) text.remove_prefix(end + 1);
  }
  return lines;
}

/// How many lines each caption has below it: as few as those allow that come before it and are on
/// at the same time.
std::vector<std::size_t> lines_below(std::span<const scenes::Caption> captions) {
  std::vector<std::size_t> order(captions.size()), below(captions.size(), 0), placed;
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::ranges::stable_sort(order, {}, [&](std::size_t c) { return captions[c].from; });
  for (const std::size_t c : order) {
    const std::size_t height = lines_of(captions[c].text).size();
    std::vector<std::pair<std::size_t, std::size_t>> taken;  // from a line on, and as far as below
    for (const std::size_t other : placed) {
      if (captions[other].until <= captions[c].from) continue;
      taken.emplace_back(below[other], below[other] + lines_of(captions[other].text).size());
    }
    std::ranges::sort(taken);
    for (const auto& [first, end] : taken) {
      if (first >= below[c] + height) break;
      below[c] = std::max(below[c], end);
    }
    placed.push_back(c);
  }
  return below;
}

std::string utf8(char32_t point) {
  std::string text;
  const auto add = [&](char32_t bits) { text += static_cast<char>(bits); };
  if (point < 0x80) {
    add(point);
  } else if (point < 0x800) {
    add(0xc0 | point >> 6);
  } else if (point < 0x10000) {
    add(0xe0 | point >> 12);
    add(0x80 | (point >> 6 & 0x3f));
  } else {
    add(0xf0 | point >> 18);
    add(0x80 | (point >> 12 & 0x3f));
    add(0x80 | (point >> 6 & 0x3f));
  }
  if (point >= 0x80) add(0x80 | (point & 0x3f));
  return text;
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
  const std::vector<std::size_t> below = lines_below(captions);
  for (std::size_t c = 0; c < captions.size(); ++c) {
    const scenes::Caption& caption = captions[c];
    const double opacity = shown(caption, playing);
    if (opacity <= 0) continue;
    Line line{picture, font, size, 0};
    for (const scenes::Caption& other : captions) {
      if (&other != &caption && (caption.list.empty() || other.list != caption.list)) continue;
      for (const std::string_view text : lines_of(other.text)) line.measure(text);
    }
    const std::vector<std::string_view> lines = lines_of(caption.text);
    const double lowest = (1 - kSafe) * picture.height - 0.3 * size;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const auto up = static_cast<double>(below[c] + lines.size() - 1 - i);
      line.y = lowest - kLeading * size * up;
      line.draw(lines[i], opacity);
    }
  }
}

namespace {

/// Says which characters the font lacks; nothing where it has all.
void add_missing(const picture::Font& font, std::string_view text, const std::string& where,
                 std::vector<std::string>& sentences) {
  constexpr std::size_t kNamed = 5;
  const std::vector<char32_t> missing = font.missing(text);
  if (missing.empty()) return;
  std::string names;
  for (std::size_t i = 0; i < std::min(missing.size(), kNamed); ++i) {
    const auto point = static_cast<std::uint32_t>(missing[i]);
    names += fmt::format("{}\"{}\" (U+{:04X})", i > 0 ? ", " : "", utf8(missing[i]), point);
  }
  if (missing.size() > kNamed)
    names += fmt::format(" and {} more characters", missing.size() - kNamed);
  sentences.push_back(fmt::format("{}: the font has no glyph for {}", where, names));
}

}  // namespace

std::vector<std::string> missing_glyphs(const scenes::Stage& stage) {
  std::vector<std::string> sentences;
  if (stage.captions.empty() && stage.title.duration <= 0 && stage.end.duration <= 0) {
    return sentences;
  }
  const picture::Font font(picture::Font::Weight::regular, picture::Font::Family::lato);
  const picture::Font bold(picture::Font::Weight::bold, picture::Font::Family::lato);
  for (std::size_t c = 0; c < stage.captions.size(); ++c) {
    add_missing(font, stage.captions[c].text, fmt::format("caption {}", c + 1), sentences);
  }
  for (const auto& [card, name] :
       {std::pair(&stage.title, "title card"), {&stage.end, "end card"}}) {
    if (card->duration <= 0) continue;
    add_missing(bold, card->heading, fmt::format("heading of the {}", name), sentences);
    add_missing(font, card->text, fmt::format("text of the {}", name), sentences);
  }
  return sentences;
}

void draw_note(picture::Picture& picture, picture::Font& font, std::string_view text) {
  const double size = std::max(0.018 * picture.height, 9.0);
  Line{picture, font, size, kSafe * picture.height + size}.draw(text, 1);
}

namespace {

constexpr picture::Rgb kCardGround{17, 15, 13}, kCardHeading{248, 245, 238},
    kCardText{190, 184, 172};
/// What is beneath a card is told by its shapes alone.
constexpr double kCardCover = 0.82;
constexpr double kCardLeading = 1.6;
constexpr double kCardMargin = 0.14;  // of the picture's width, on the left and on the right

std::string with_method(std::string text, std::string_view method) {
  constexpr std::string_view kPlace = "{method}";
  for (std::size_t at = 0; (at = text.find(kPlace, at)) != std::string::npos; at += method.size())
    text.replace(at, kPlace.size(), method);
  return text;
}

/// Rises from 0 to 1 with x, and stands still at both.
double eased(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

}  // namespace

void draw_card(picture::Picture& picture, picture::Font& font, picture::Font& bold,
               const scenes::Card& card, std::string_view method, double shown) {
  // Lines come when the ground is all there.
  picture::fill(picture, {0, 0, picture.width, picture.height}, kCardGround,
                kCardCover * eased(2 * shown));
  const double opacity = eased(2 * shown - 1);
  if (opacity <= 0) return;
  const double large = 0.12 * picture.height, small = 0.034 * picture.height;
  const double x = kCardMargin * picture.width, width = picture.width - 2 * x;
  std::vector<std::string> lines;
  std::istringstream text(with_method(card.text, method));
  text.exceptions(std::ios::badbit);  // or running out of memory would end the text
  for (std::string line; std::getline(text, line);)
    for (std::string& part : picture::wrapped(font, line, small, width))
      lines.push_back(std::move(part));
  const double below = 0.45 * large + kCardLeading * small * double(lines.size());
  double y = (picture.height + 0.7 * large - below) / 2;  // capitals are 0.7 of the letters' size
  bold.draw(picture, card.heading, x, y, large, kCardHeading, opacity);
  y += 0.45 * large;
  for (const std::string& line : lines)
    font.draw(picture, line, x, y += kCardLeading * small, small, kCardText, opacity);
}

}  // namespace taut::film
