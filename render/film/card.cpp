#include "render/film/card.h"

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "render/picture/paint.h"

namespace taut::film {
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
