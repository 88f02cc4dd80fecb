// A comparison's charts, its table, and the line that runs along the charts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/film/comparison.h"
#include "render/film/comparison_colors.h"
#include "render/picture/paint.h"

namespace taut::film {
namespace {

constexpr double kLeastDistance = 1e-4;  // mm, of the chart
constexpr double kLeastStretch = 1e-4;   // %, of the chart

}  // namespace

void ComparisonFilm::draw_charts() {
  chart::Chart chart;
  chart.columns = layout_ == Layout::over ? 1 : 2;
  const auto points = [&](const std::vector<double>& values, double unit) {
    std::vector<chart::Point> list;
    for (std::size_t k = 0; k < values.size(); ++k)
      list.push_back({comparison_.times[k], values[k] > 0 ? unit * values[k] : chart::kAuto});
    return list;
  };
  const double end = comparison_.times.back();
  const auto panel_of = [&](const std::string& title, const char* unit, double least) {
    chart::Panel panel;
    panel.title = title;
    panel.x.label = "time (s)";
    panel.x.minimum = 0;
    panel.x.maximum = end;
    panel.y.label = unit;
    panel.y.log = true;
    panel.y.minimum = least;
    return panel;
  };
  const auto curve = [](const ComparedMethod& method, std::vector<chart::Point> list) {
    chart::Series series;
    series.name = method.label;
    series.style = method.style;
    series.markers = false;
    series.points = std::move(list);
    return series;
  };
  chart::Panel distance =
      panel_of("Mean distance from " + comparison_.measured_from, "mm", kLeastDistance);
  chart::Panel stretch = panel_of("Stretch of the worst link", "%", kLeastStretch);
  for (const ComparedMethod& method : comparison_.methods) {
    distance.series.push_back(curve(method, points(method.distance, 1e3)));
    stretch.series.push_back(curve(method, points(method.stretch, 1e2)));
  }
  for (chart::Panel* panel : {&distance, &stretch})
    if (comparison_.horizon < end) panel->rules.push_back({comparison_.horizon, true, "horizon"});
  chart.panels = {distance, stretch};

  // Charts have type of one size: they are drawn large, and shrunk where the picture is small.
  const int factor = std::max((1080 + height_ - 1) / height_, 1);
  chart.width = areas_.charts.width * factor;
  chart.height = areas_.charts.height * factor;
  const std::string png = chart::draw_chart(chart, chart::ChartFormat::png);
  picture::paste(
      picture::shrunk(
          picture::decode_png({reinterpret_cast<const std::uint8_t*>(png.data()), png.size()}),
          factor),
      still_, areas_.charts.x, areas_.charts.y);
  for (std::size_t i = 0; i < chart.panels.size(); ++i) {
    const chart::PlotArea area = chart::plot_area(chart, i);
    plots_.push_back({areas_.charts.x + area.left / factor, areas_.charts.y + area.top / factor,
                      areas_.charts.x + area.right / factor,
                      areas_.charts.y + area.bottom / factor});
  }
}

void ComparisonFilm::draw_table() {
  const double size = 0.0165 * height_, row = 1.75 * size;
  const double left = areas_.table.x + size, right = areas_.table.right() - size;
  const chart::Table& table = comparison_.table;
  const double first = 0.30 * (right - left);
  const double other =
      (right - left - first) / double(std::max(table.columns.size(), std::size_t(2)) - 1);
  // Words begin at the left of the first column, numbers end at the right of theirs.
  const auto put = [&](picture::Font& font, const std::string& text, std::size_t column, double y,
                       picture::Rgb ink) {
    const double end = left + first + other * double(column);
    font.draw(still_, text, column ? end - font.width(text, size) : left, y, size, ink);
  };
  double bottom = areas_.table.y + 1.5 * size;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    double y = areas_.table.y + 1.6 * size;
    for (const std::string& line :
         picture::wrapped(font_, table.columns[c], size, c ? 0.9 * other : first)) {
      put(font_, line, c, y, kGrey);
      bottom = std::max(bottom, y);
      y += 1.25 * size;
    }
  }
  double y = bottom + 0.6 * size;
  picture::fill(still_, {int(left), int(y), int(right - left), 1}, kGrey);
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    y += row;
    picture::fill(still_,
                  {int(left - 0.7 * size), int(y - 0.75 * size), int(0.4 * size), int(0.8 * size)},
                  rgb(comparison_.methods[r].style.color));
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      put(c ? font_ : bold_, table.rows[r][c], c, y, kInk);
  }
  y += 1.2 * row;
  std::string note =
      "Distances: means over segments and frames, from the truth up to its horizon. ";
  if (comparison_.horizon > 0)
    note += fmt::format("Translucent: the truth, known to {:.0e} m and predictable for {:.3g} s.",
                        comparison_.self_error, comparison_.horizon);
  else
    note += "Here the truth is not predictable for a single frame.";
  for (const std::string& line : picture::wrapped(font_, note, size, right - left)) {
    font_.draw(still_, line, left, y, size, kGrey);
    y += 1.35 * size;
  }
}

void ComparisonFilm::draw_cursor(picture::Picture& picture, std::size_t frame) {
  const double end = std::max(comparison_.times.back(), 1e-9);
  const int wide = std::max(height_ / 540, 1);
  for (const chart::PlotArea& plot : plots_) {
    const double x = std::lerp(plot.left, plot.right, comparison_.times[frame] / end);
    const int top = int(std::lround(plot.top)), high = int(std::lround(plot.bottom)) - top;
    // The rest of the curve is only hinted at.
    picture::fill(picture, {int(x) + 1, top + 1, int(plot.right) - int(x) - 1, high - 2}, kPaper,
                  0.82);
    picture::fill(picture, {int(x), top, wide, high}, kInk, 0.8);
  }
  const double size = 0.024 * height_;
  const std::string text = fmt::format("{:.2f} s", comparison_.times[frame]);
  bold_.draw(picture, text, areas_.table.x + 0.7 * size, areas_.table.y + 3 * size, size, kInk);
}

}  // namespace taut::film
