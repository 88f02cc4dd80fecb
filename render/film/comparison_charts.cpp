// A comparison's charts and costs, and the line that runs along the charts.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "render/film/comparison.h"
#include "render/film/comparison_colors.h"
#include "render/picture/paint.h"

namespace taut::film {
namespace {

constexpr double kMost = 1e3;  // a share; what is beyond is drawn there
constexpr picture::Rgb kLine = {222, 224, 228}, kBand = {214, 238, 220};

/// Values over decades and around zero: linear up to `least`, logarithmic beyond.
double scaled(double value, double least) {
  return std::copysign(std::log10(1 + std::abs(value) / least), value);
}

/// A power of ten with its unit.
std::string decade(double seconds) {
  if (seconds < 0.9e-3) return fmt::format("{:.0f} µs", 1e6 * seconds);
  return seconds < 0.9 ? fmt::format("{:.0f} ms", 1e3 * seconds) : fmt::format("{:.0f} s", seconds);
}

/// A number with two digits, without exponent.
std::string two_digits(double value) {
  if (value < 0.01) return fmt::format("{:.1g}", value);
  if (value < 9.95) return fmt::format("{:.2g}", value);
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  const std::string digits = fmt::format("{:.0f}", std::round(value / unit) * unit);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

/// A time in its unit, with two digits.
std::string duration(double seconds) {
  if (seconds < 0.95e-3) return two_digits(1e6 * seconds) + " µs";
  return seconds < 0.95 ? two_digits(1e3 * seconds) + " ms" : two_digits(seconds) + " s";
}

}  // namespace

void ComparisonFilm::draw_charts() {
  const picture::Rect& area = areas_.charts;
  std::vector<Measure> measures;
  if (comparison_.by_truth)
    measures.push_back(Measure::distance);
  else if (std::ranges::any_of(comparison_.methods,
                               [](const ComparedMethod& method) { return !method.energy.empty(); }))
    measures.push_back(Measure::energy);
  measures.push_back(Measure::stretch);
  const int wide = area.width / int(measures.size());
  for (int i = 0; const Measure measure : measures)
    draw_chart(measure, {area.x + i++ * wide, area.y, wide, area.height});
}

void ComparisonFilm::draw_chart(Measure measure, const picture::Rect& area) {
  const double size = 0.85 * unit_;
  Plot plot{.area = {area.x + int((measure == Measure::distance ? 5 : 4.2) * size),
                     area.y + int(1.9 * unit_),
                     area.width - int((measure == Measure::distance ? 6 : 5.2) * size),
                     area.height - int(3.6 * unit_)}};
  if (plot.area.width < 8 || plot.area.height < 8) return;
  const bool signs = measure == Measure::energy;
  const double kept = measure == Measure::distance ? kKept * comparison_.length : kKept;
  const double least = kept / (measure == Measure::distance ? 100 : 10);
  const auto values_of = [&](const ComparedMethod& method) -> const std::vector<double>& {
    return measure == Measure::distance ? method.distance
           : measure == Measure::energy ? method.energy
                                        : method.stretch;
  };
  plot.high = scaled(2 * kept, least);
  plot.low = signs ? -plot.high : 0;
  for (const ComparedMethod& method : comparison_.methods)
    for (const double value : values_of(method)) {
      const double y = scaled(std::clamp(value, -kMost, kMost), least);
      plot.low = std::min(plot.low, signs ? 1.05 * y : 0.0);
      plot.high = std::max(plot.high, 1.05 * y);
    }
  const double end = std::max(comparison_.times.back(), 1e-9);
  const auto height_of = [&](double value) {
    const double share = (scaled(value, least) - plot.low) / (plot.high - plot.low);
    return plot.area.top() - std::clamp(share, 0.0, 1.0) * plot.area.height;
  };
  const auto place_of = [&](double time) { return plot.area.x + time / end * plot.area.width; };

  const std::string title = measure == Measure::distance ? "Mean distance from the truth"
                            : signs                      ? "Energy gained or lost"
                                                         : "Stretch of the worst link";
  const double left = area.x + 0.6 * size;
  const double fits = std::min(1.0, (area.width - 1.6 * size) / bold_.width(title, unit_));
  for (picture::Picture* picture : {&faint_, &full_}) {
    const int top = int(std::lround(height_of(kept))),
              bottom = signs && comparison_.loses ? plot.area.top()
                                                  : int(std::lround(height_of(signs ? -kept : 0)));
    picture::fill(*picture, {plot.area.x, top, plot.area.width, bottom - top}, kBand);
    bold_.draw(*picture, title, left, area.y + 1.3 * unit_, fits * unit_, kInk);
    const double scale = left + bold_.width(title, unit_) + 0.6 * unit_;
    if (signs && scale + font_.width(comparison_.energy_scale, size) < area.right() - 0.3 * unit_)
      font_.draw(*picture, comparison_.energy_scale, scale, area.y + 1.3 * unit_, size, kGrey);
    // Decades from that of what is kept on, outwards; zero.
    std::vector<double> tics{0};
    const double unit =
        measure == Measure::distance ? std::pow(10, std::ceil(std::log10(least))) : kept;
    for (double tic = unit; tic <= kMost; tic *= 10) {
      tics.push_back(tic);
      if (signs) tics.push_back(-tic);
    }
    std::vector<double> taken;
    for (const double tic : tics) {
      const double at = scaled(tic, least);
      if (at < plot.low || at > plot.high) continue;
      const double y = height_of(tic);
      if (std::ranges::any_of(taken,
                              [&](double other) { return std::abs(y - other) < 1.1 * size; }))
        continue;
      taken.push_back(y);
      picture::fill(*picture, {plot.area.x, int(y), plot.area.width, 1}, kLine);
      const std::string text = measure == Measure::distance ? fmt::format("{:g} mm", 1e3 * tic)
                                                            : fmt::format("{}{:g}%",
                                                                          tic < 0            ? "−"
                                                                          : signs && tic > 0 ? "+"
                                                                                             : "",
                                                                          100 * std::abs(tic));
      font_.draw(*picture, text, plot.area.x - 0.4 * size - font_.width(text, 0.9 * size),
                 y + 0.33 * size, 0.9 * size, kGrey);
    }
    const double step = [&] {
      const double power = std::pow(10, std::floor(std::log10(end)));
      for (const double part : {0.1, 0.2, 0.5, 1.0, 2.0, 5.0})
        if (place_of(part * power) - place_of(0) > 3.2 * size) return part * power;
      return 10 * power;
    }();
    for (int k = 0; k * step <= end * (1 + 1e-9); ++k) {
      const std::string text = fmt::format("{:g}{}", k * step, k == 0 ? " s" : "");
      font_.draw(*picture, text, place_of(k * step) - font_.width(text, 0.9 * size) / 2,
                 plot.area.top() + 1.2 * size, 0.9 * size, kGrey);
      picture::fill(*picture, {int(place_of(k * step)), plot.area.top() - 3, 1, 3}, kGrey);
    }
    if (comparison_.by_truth && comparison_.horizon < end)
      picture::fill(*picture,
                    {int(place_of(comparison_.horizon)), plot.area.y, 1, plot.area.height}, kGrey);
    for (const ComparedMethod& method : comparison_.methods) {
      std::vector<std::array<double, 2>> line;
      const std::vector<double>& values = values_of(method);
      for (std::size_t k = 0; k < values.size(); ++k)
        line.push_back(
            {place_of(comparison_.times[k]), height_of(std::clamp(values[k], -kMost, kMost))});
      picture::stroke(*picture, line, std::max(0.13 * unit_, 1.2), rgb(method.style.color),
                      picture == &full_ ? 1 : 0.22);
    }
    picture::fill(*picture, {plot.area.x, plot.area.y, 1, plot.area.height}, kGrey);
  }
  plots_.push_back(plot);
}

/// CPU time as bars on a logarithmic scale, and how fast that is beside real time.
void ComparisonFilm::draw_costs() {
  const picture::Rect& area = areas_.costs;
  const double left = area.x + unit_, right = area.right() - unit_;
  bold_.draw(faint_, "CPU time for 1 s of motion", left, area.y + 1.3 * unit_, unit_, kInk);
  const double size = unit_, small = 0.85 * unit_;
  double names = 0, least = INFINITY, most = 0;
  std::vector<double> costs;  // s to a second of motion
  for (const ComparedMethod& method : comparison_.methods) {
    const double seconds = 1e-6 * method.cpu_us * comparison_.fps;
    if (seconds > 0) {
      least = std::min(least, seconds);
      most = std::max(most, seconds);
    }
    costs.push_back(seconds);
    names = std::max(names, bold_.width(method.label, size));
  }
  if (!(most > 0)) least = most = 1e-3;
  const double low = std::floor(std::log10(least) - 0.3), high = std::log10(most);
  const double start = left + names + unit_;
  std::vector<std::string> texts;
  double wide = 0;
  for (const bool brief : {false, true}) {  // the bars keep a third of the room
    if (brief && wide > (right - start) / 3) break;
    texts.clear();
    wide = right - start - 0.6 * unit_;
    for (const double seconds : costs) {
      std::string text = "not run";
      if (seconds > 0) text = two_digits(1 / seconds) + " times real time";
      if (seconds > 0 && !brief) text = duration(seconds) + ", " + text;
      wide = std::min(wide, right - start - 0.6 * unit_ - font_.width(text, small));
      texts.push_back(std::move(text));
    }
  }
  const double row = std::min(
      1.75 * unit_, (area.height - 3.4 * unit_) / double(std::max<std::size_t>(costs.size(), 1)));
  if (wide < 4 || row < 2) return;
  const auto length_of = [&](double seconds) {
    return std::max((std::log10(seconds) - low) / std::max(high - low, 1e-9) * wide, 1.0);
  };
  const double top = area.y + 1.9 * unit_, bottom = top + row * double(costs.size());
  double free = start - unit_;  // where the next label may begin
  for (double power = low; power <= high + 1e-9; power += 1) {
    const double x = start + (power - low) / std::max(high - low, 1e-9) * wide;
    picture::fill(faint_, {int(x), int(top), 1, int(bottom - top)}, kLine);
    const std::string text = decade(std::pow(10, power));
    const double half = font_.width(text, small) / 2;
    if (x - half < free) continue;
    font_.draw(faint_, text, x - half, bottom + 1.2 * small, small, kGrey);
    free = x + half + small;
  }
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const ComparedMethod& method = comparison_.methods[i];
    const double line = top + row * (double(i) + 0.5) + 0.36 * size;
    bold_.draw(faint_, method.label, left, line, size, kInk);
    double x = start;
    if (costs[i] > 0) {
      const double bar = length_of(costs[i]);
      picture::fill(faint_,
                    {int(start), int(top + row * (double(i) + 0.2)), int(std::lround(bar)),
                     std::max(int(0.6 * row), 1)},
                    rgb(method.style.color));
      x += bar + 0.5 * unit_;
    }
    font_.draw(faint_, texts[i], x, line, small, kInk);
  }
}

void ComparisonFilm::draw_cursor(picture::Picture& picture, std::size_t instant) {
  const double end = std::max(comparison_.times.back(), 1e-9);
  const int wide = std::max(int(0.1 * unit_), 1);
  for (const Plot& plot : plots_) {
    const auto [left, top, width, height] = plot.area;
    const int x =
        left + int(std::lround(std::min(comparison_.time_of(instant) / end, 1.0) * width));
    for (int y = top; y < plot.area.top(); ++y)
      std::copy_n(full_.at(left, y), std::size_t(x - left) * 4, picture.at(left, y));
    picture::fill(picture, {x, top, wide, height}, kInk, 0.8);
  }
}

}  // namespace taut::film
