// A comparison's words: names, running numbers, verdicts, the clock, stops and the card.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/film/comparison.h"
#include "render/film/comparison_colors.h"
#include "render/picture/paint.h"

namespace taut::film {
namespace {

constexpr picture::Rgb kGround{17, 15, 13}, kClause{205, 200, 190};

/// A share in percent, in few letters: "0%", "0.02%", "1.5%", "180%".
std::string percent(double share, bool sign) {
  const double value = 100 * std::abs(share);
  const char* before = value < 0.01 ? "" : share < 0 ? "−" : sign ? "+" : "";
  if (value < 0.01) return "0%";
  if (value < 0.1) return fmt::format("{}{:.2f}%", before, value);
  if (value < 9.95) return fmt::format("{}{:.1f}%", before, value);
  return value < 1e5 ? fmt::format("{}{:.0f}%", before, value)
                     : fmt::format("{}{:.0e}%", before, value);
}

std::string millimetres(double metres) {
  const double mm = 1e3 * metres;
  if (mm < 0.001) return "0 mm";
  return mm < 0.01  ? fmt::format("{:.3f} mm", mm)
         : mm < 100 ? fmt::format("{:.2g} mm", mm)
                    : fmt::format("{:.0f} mm", mm);
}

/// The size at which a line is no wider than `width`, at most `size`.
double fitted(picture::Font& font, const std::string& text, double size, double width) {
  return size * std::clamp(width / std::max(font.width(text, size), 1e-9), 0.2, 1.0);
}

}  // namespace

/// What runs with the clock: the distance from the truth, or energy and stretch.
std::vector<std::string> ComparisonFilm::numbers(const ComparedMethod& method,
                                                 std::size_t instant) const {
  const std::size_t frame = comparison_.frame_of(instant);
  std::vector<std::string> lines;
  if (comparison_.by_truth) {
    if (frame < method.distance.size())
      lines.push_back(millimetres(method.distance[frame]) + " off");
    return lines;
  }
  if (frame < method.energy.size())
    lines.push_back("energy " + percent(method.energy[frame], true));
  if (frame < method.stretch.size())
    lines.push_back("stretch " + percent(method.stretch[frame], false));
  return lines;
}

/// The name in one line, or broken at its dashes.
std::vector<std::string> ComparisonFilm::name_lines(const ComparedMethod& method, double width) {
  const double size = 1.1 * unit_;
  std::vector<std::string> lines{""};
  std::string rest = method.label;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find_first_of("-:"), rest.size() - 1) + 1;
    const std::string part = rest.substr(0, end);
    if (!lines.back().empty() && bold_.width(lines.back() + part, size) > width)
      lines.push_back(part);
    else
      lines.back() += part;
    rest.erase(0, end);
  }
  return lines;
}

void ComparisonFilm::draw_header(picture::Picture& picture, const Moment& moment) {
  const picture::Rect& area = areas_.header;
  const double line = area.y + 0.5 * area.height + 0.4 * unit_, gap = 0.6 * unit_;
  const std::string clock = fmt::format("{:.2f} s", comparison_.time_of(moment.instant));
  const std::string speed =
      moment.slower > 1 ? fmt::format("{} times slower", moment.slower) : "real time";
  const double wide = bold_.width("00.00 s", 1.2 * unit_),
               pace = font_.width("00 times slower", 0.9 * unit_);
  double x = area.right() - gap - pace;
  font_.draw(picture, speed, x, line, 0.9 * unit_, kGrey);
  x -= gap + wide;
  bold_.draw(picture, clock, x, line, 1.2 * unit_, kInk);
  const double title = fitted(bold_, comparison_.title, 1.2 * unit_, 0.5 * x);
  bold_.draw(picture, comparison_.title, gap, line, title, kInk);
  const double left = 2 * gap + bold_.width(comparison_.title, title);
  const double size = fitted(font_, comparison_.judged, 0.95 * unit_, x - gap - left);
  font_.draw(picture, comparison_.judged, left, line, size, kGrey);
}

void ComparisonFilm::draw_panel(picture::Picture& picture, std::size_t index, std::size_t instant) {
  const ComparedMethod& method = comparison_.methods[index];
  const auto& [cell, view] = panels_[index];
  const double gap = unit_ / 2, width = cell.width - 2 * gap;
  const bool stopped = is_stopped(method, instant);
  if (stopped) picture::fill(picture, view, kPaper, 0.55);
  picture::fill(picture, {cell.x, cell.y, cell.width, view.y - cell.y}, kPaper);
  picture::fill(picture, {cell.x, cell.y, cell.width, std::max(int(0.3 * unit_), 2)},
                rgb(method.style.color));

  double y = cell.y + 0.35 * unit_;
  double below = 0;  // where the last line of the name ends
  for (const std::string& line : name_lines(method, width)) {
    const double size = fitted(bold_, line, 1.1 * unit_, width);
    bold_.draw(picture, line, cell.x + gap, y += 1.2 * unit_, size, kInk);
    below = bold_.width(line, size);
  }
  const auto lines = numbers(method, instant);
  double x = cell.x + gap;
  const bool beside = width >= 16 * unit_;
  if (!beside || lines.size() > 1 || below + 9 * unit_ > width) y += 1.2 * unit_;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double size = fitted(font_, lines[i], unit_, width);
    if (lines.size() == 1 && beside) x = cell.right() - gap - font_.width(lines[i], size);
    font_.draw(picture, lines[i], x, y, size, kInk);
    if (beside)
      x += std::max(font_.width(lines[i], size) + unit_, 9 * unit_);
    else
      y += 1.2 * unit_;
  }

  if (stopped) {
    double at = view.y + 0.3 * view.height;
    for (const std::string& text :
         picture::wrapped(font_, method.failure, 0.85 * unit_, width - gap))
      font_.draw(picture, text, cell.x + gap, at += 1.2 * unit_, 0.85 * unit_, kInk);
  }
  if (comparison_.by_truth) {
    const bool known = comparison_.time_of(instant) <= comparison_.horizon;
    const std::string text =
        known ? "ghost: the truth"
              : fmt::format("no truth after {:.2g} s: not predictable", comparison_.horizon);
    const double size = fitted(font_, text, 0.8 * unit_, width);
    const double wide = font_.width(text, size), left = cell.right() - gap - wide;
    picture::fill(
        picture,
        {int(left - 0.4 * size), int(view.y + 0.3 * size), int(wide + 0.8 * size), int(1.4 * size)},
        kPaper, 0.6);
    font_.draw(picture, text, left, view.y + 1.35 * size, size, kGrey);
  }

  picture::fill(picture, {cell.x, view.top(), cell.width, cell.top() - view.top()},
                rgb(method.verdict.grade));
  const double size = verdict_size(cell);
  double at = view.top() - 0.05 * size;
  for (const std::string& text : picture::wrapped(bold_, method.verdict.text, size, width))
    bold_.draw(picture, text, cell.x + gap, at += 1.25 * size, fitted(bold_, text, size, width),
               kPaper);
  for (const int edge : {cell.x, cell.right() - 1})
    picture::fill(picture, {edge, cell.y, 1, cell.height}, kPaper);
}

/// Whose colour is whose, where methods lie over each other: names, running numbers, verdicts.
void ComparisonFilm::draw_list(picture::Picture& picture, std::size_t instant) {
  const picture::Rect& area = areas_.list;
  const std::size_t count = comparison_.methods.size();
  const double row = area.height / (double(count) + 1.5), gap = 0.6 * unit_;
  const double size = std::min(unit_, 0.75 * row);
  double names = 0, figures = 0;
  for (const ComparedMethod& method : comparison_.methods)
    names = std::max(names, bold_.width(method.label, size));
  std::size_t columns = comparison_.by_truth ? 1 : 2;
  figures = font_.width("+0000%", size);
  const double first = area.x + gap + 1.2 * size;
  // All verdicts in letters of one size; numbers where there is room for them.
  double verdict = size;
  const auto left = [&] { return first + names + double(columns) * (figures + gap) + gap; };
  for (const bool roomy : {true, false}) {
    if (!roomy) columns = 0;
    verdict = size;
    for (const ComparedMethod& method : comparison_.methods)
      verdict =
          std::min(verdict, fitted(bold_, method.verdict.text, size, area.right() - gap - left()));
    if (verdict > 0.85 * size) break;
  }
  if (columns == 2) {
    for (std::size_t c = 0; c < 2; ++c) {
      const std::string text = c ? "stretch" : "energy";
      const double end = first + names + double(c + 1) * (figures + gap);
      font_.draw(picture, text, end - font_.width(text, 0.85 * size), area.y + row, 0.85 * size,
                 kGrey);
    }
  }
  double y = area.y + row;
  for (const ComparedMethod& method : comparison_.methods) {
    y += row;
    picture::fill(picture,
                  {int(area.x + gap), int(y - 0.75 * size), int(0.8 * size), int(0.8 * size)},
                  rgb(method.style.color));
    bold_.draw(picture, method.label, first, y, size, kInk);
    const auto lines = numbers(method, instant);
    for (std::size_t c = 0; c < lines.size() && columns > 0; ++c) {
      const std::string value =
          comparison_.by_truth ? lines[c] : lines[c].substr(lines[c].find(' ') + 1);
      const std::size_t column = lines[c].starts_with("stretch") ? 1 : 0;
      const double end = first + names + double(column + 1) * (figures + gap);
      font_.draw(picture, value, end - font_.width(value, size), y, size, kInk);
    }
    bold_.draw(picture, method.verdict.text, left(), y, verdict, rgb(method.verdict.grade));
  }
}

/// A stop at a method's worst moment: its verdict, large.
void ComparisonFilm::draw_stop(picture::Picture& picture, const Moment& moment) {
  const auto& stopped = moment.stopped;
  const ComparedMethod& method = comparison_.methods[stopped.front()];
  const picture::Rgb color = rgb(method.verdict.grade);
  if (layout_ == Layout::beside)
    for (std::size_t i = 0; i < panels_.size(); ++i) {
      const picture::Rect& cell = panels_[i].cell;
      if (std::ranges::find(stopped, i) == stopped.end()) {
        picture::fill(picture, cell, kPaper, 0.7);
        continue;
      }
      const int thick = std::max(int(0.3 * unit_), 2);
      picture::fill(picture, {cell.x, cell.y, cell.width, thick}, color);
      picture::fill(picture, {cell.x, cell.y, thick, cell.height}, color);
      picture::fill(picture, {cell.right() - thick, cell.y, thick, cell.height}, color);
    }
  std::string text;
  for (std::size_t k = 0; k < stopped.size(); ++k)
    text += (k == 0                   ? ""
             : k + 1 < stopped.size() ? ", "
                                      : " and ") +
            comparison_.methods[stopped[k]].label;
  const bool alone = stopped.size() == 1 && !comparison_.by_truth;
  text += (alone ? " " : ": ") + method.verdict.text;
  const picture::Rect& area = areas_.panels;
  const int high = std::min(int(3.4 * unit_), area.height);
  const picture::Rect band{0, area.top() - high, width_, high};
  picture::fill(picture, band, color);
  const double size = fitted(bold_, text, 2.1 * unit_, width_ - 2 * unit_);
  bold_.draw(picture, text, (width_ - bold_.width(text, size)) / 2,
             band.y + 0.5 * high + 0.36 * size, size, kPaper);
}

/// The result in one sentence, a clause in each line.
void ComparisonFilm::draw_card(picture::Picture& picture, double shown) {
  picture::fill(picture, {0, 0, width_, height_}, kGround, 0.94 * shown);
  if (shown < 1) return;
  const double left = 0.08 * width_, width = width_ - 2 * left;
  struct Line {
    std::string text;
    double size;
    std::optional<picture::Rgb> mark;
    bool bold;
  };
  std::vector<Line> lines;
  double high = 0;
  const auto& clauses = comparison_.result;
  for (std::size_t i = 0; i < clauses.size(); ++i) {
    const std::string text = clauses[i] + (i + 1 < clauses.size() ? ";" : ".");
    const auto of = std::ranges::find_if(comparison_.methods, [&](const ComparedMethod& method) {
      return clauses[i].starts_with(method.label + " ") ||
             clauses[i].starts_with(method.label + ": ");
    });
    const Verdict::Grade grade =
        of == comparison_.methods.end() ? Verdict::Grade::none : of->verdict.grade;
    const bool right = grade == Verdict::Grade::kept;
    const double size = (right ? 1.6 : 1.35) * unit_;
    bool first = true;
    for (const std::string& part :
         picture::wrapped(right ? bold_ : font_, text, size, width - 1.6 * size)) {
      lines.push_back({part, size, std::nullopt, right});
      if (std::exchange(first, false)) lines.back().mark = rgb(grade);
      high += 1.6 * size;
    }
  }
  // Smaller where there are more lines than fit.
  const double title = 2.4 * unit_;
  const double scale = std::min(1.0, 0.86 * height_ / (high + 1.6 * title));
  double y = (height_ - scale * (high + 1.6 * title)) / 2 + scale * title;
  bold_.draw(picture, comparison_.title, left, y,
             fitted(bold_, comparison_.title, scale * title, width), kPaper);
  y += 0.4 * scale * title;
  for (const Line& line : lines) {
    const double size = scale * line.size;
    y += 1.6 * size;
    if (line.mark)
      picture::fill(picture, {int(left), int(y - 0.72 * size), int(0.75 * size), int(0.75 * size)},
                    *line.mark);
    (line.bold ? bold_ : font_)
        .draw(picture, line.text, left + 1.4 * size, y, size, line.bold ? kPaper : kClause);
  }
  std::string note = "Times: CPU time for a second of motion";
  if (!comparison_.by_truth &&
      std::ranges::any_of(comparison_.methods,
                          [](const ComparedMethod& method) { return !method.energy.empty(); }))
    note += ". Energy: in % " + comparison_.energy_scale;
  font_.draw(picture, note, left, y + 2.2 * scale * unit_, scale * unit_, {150, 146, 138});
}

}  // namespace taut::film
