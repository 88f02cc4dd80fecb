#include "render/film/card.h"

#include <sstream>
#include <string>
#include <vector>

#include "render/picture/paint.h"

namespace taut::film {
namespace {

constexpr double kDarkness = 0.6;  // of the picture behind
constexpr double kCardLeading = 1.6;
constexpr picture::Rgb kCardPaper{248, 245, 238}, kQuiet{206, 200, 188};

std::string with_method(std::string text, std::string_view method) {
  constexpr std::string_view kPlace = "{method}";
  for (std::size_t at = 0; (at = text.find(kPlace, at)) != std::string::npos; at += method.size())
    text.replace(at, kPlace.size(), method);
  return text;
}

}  // namespace

void draw_card(picture::Picture& picture, picture::Font& font, picture::Font& bold,
               const scenes::Card& card, std::string_view method, double shown) {
  picture::fill(picture, {0, 0, picture.width, picture.height}, {10, 9, 8}, kDarkness * shown);
  const double large = 0.11 * picture.height, small = 0.034 * picture.height;
  const auto centred = [&](picture::Font& face, std::string_view line, double size, double y,
                           picture::Rgb color) {
    const double x = (picture.width - face.width(line, size)) / 2;
    face.draw(picture, line, x, y, size, color, shown);
  };
  double y = 0.45 * picture.height;
  centred(bold, card.heading, large, y, kCardPaper);
  y += 0.75 * large;
  std::istringstream lines(with_method(card.text, method));
  lines.exceptions(std::ios::badbit);  // or running out of memory would end the text
  for (std::string line; std::getline(lines, line); y += kCardLeading * small)
    centred(font, line, small, y, kQuiet);
}

}  // namespace taut::film
