#include "render/chart/chart_layout.h"

#include <algorithm>
#include <cmath>

namespace taut::chart {
namespace chart_layout {
namespace {

constexpr double kWide = 0.58;  // mean width of a letter, as a share of its height

// Letters of UTF-8 text, good enough for widths.
std::size_t letters(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

std::vector<std::string> wrapped(const std::string& text, double width, double height) {
  const auto most = static_cast<std::size_t>(std::max(10.0, width / (kWide * height)));
  std::vector<std::string> lines;
  std::string line, word;
  const auto take = [&] {
    if (word.empty()) return;
    if (!line.empty() && letters(line) + 1 + letters(word) > most)
      lines.push_back(std::move(line)), line.clear();
    line += (line.empty() ? "" : " ") + word;
    word.clear();
  };
  for (const char c : text) {
    if (c == ' ' || c == '\n')
      take();
    else
      word += c;
  }
  take();
  if (!line.empty()) lines.push_back(line);
  return lines;
}

// Something of it lies in the panel: no series of a method that is missing, or that ran nowhere.
bool is_drawn(const Panel& panel, const Series& series) {
  return std::ranges::any_of(series.points, [&](const Point& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && (!panel.x.log || p.x > 0) &&
           (!panel.y.log || p.y > 0);
  });
}

bool is_drawn(const Chart& chart, std::size_t kind) {
  return std::ranges::any_of(chart.panels, [&](const Panel& panel) {
    return std::ranges::any_of(panel.cells, [&](const Cell& cell) { return cell.kind == kind; });
  });
}

// Names of what is drawn.
std::vector<Entry> legend_entries(const Chart& chart) {
  std::vector<Entry> entries;
  if (!chart.legend) return entries;
  for (const Panel& panel : chart.panels) {
    for (const Series& series : panel.series) {
      const bool known = std::any_of(entries.begin(), entries.end(),
                                     [&](const Entry& e) { return e.name == series.name; });
      if (series.name.empty() || known || !is_drawn(panel, series)) continue;
      entries.push_back({series.name, &series.style, series.line, series.markers, nullptr});
    }
  }
  for (std::size_t k = 0; k < chart.kinds.size(); ++k) {
    const CellKind& kind = chart.kinds[k];
    if (!is_drawn(chart, k)) continue;
    entries.push_back({kind.letter.empty() ? kind.name : kind.letter + "  " + kind.name, nullptr,
                       false, false, &kind});
  }
  return entries;
}

}  // namespace

bool is_label_right(const Panel& panel, const Rule& rule) {
  if (rule.vertical) return false;
  constexpr double kWidth = 0.2, kBelow = 0.01, kAbove = 0.06;  // of the panel, around the label
  constexpr int kSamples = 40;                                  // of a line between two points
  const auto x = x_range(panel), y = y_range(panel);
  const auto share = [](const Axis& axis, std::pair<double, double> range, double v) {
    if (axis.log) return std::log(v / range.first) / std::log(range.second / range.first);
    return (v - range.first) / (range.second - range.first);
  };
  const double height = share(panel.y, y, rule.at);
  int left = 0, right = 0;
  for (const Series& series : panel.series) {
    const std::size_t lines = series.line ? series.points.size() : 0;
    for (std::size_t i = 0; i + 1 < lines; ++i) {
      const Point &a = series.points[i], &b = series.points[i + 1];
      const double ax = share(panel.x, x, a.x), bx = share(panel.x, x, b.x);
      const double ay = share(panel.y, y, a.y), by = share(panel.y, y, b.y);
      for (int k = 0; k <= kSamples; ++k) {
        const double along = ax + (bx - ax) * k / kSamples;
        const double above = ay + (by - ay) * k / kSamples - height;
        if (!(above > -kBelow && above < kAbove)) continue;
        left += along < kWidth;
        right += along > 1 - kWidth;
      }
    }
  }
  return right < left;
}

std::string name_in(const Panel& panel, const Series& series) {
  if (!series.name.empty()) return series.name;
  for (const Series& other : panel.series) {
    if (!other.name.empty() && other.style == series.style) return other.name;
  }
  return {};
}

Layout layout_of(const Chart& chart) {
  Layout layout;
  const double width = chart.width - 2 * kMargin;
  layout.title = wrapped(chart.title, width, kTitle * 1.05);
  layout.subtitle = wrapped(chart.subtitle, width, kText);
  layout.top = kMargin * 0.7 + kLine * (kTitle * static_cast<double>(layout.title.size()) +
                                        kText * static_cast<double>(layout.subtitle.size()));

  layout.legend = legend_entries(chart);
  const double row = 1.6 * kText;
  double x = kMargin, y = 0;
  for (Entry& entry : layout.legend) {
    const double wide =
        (entry.style ? 52 : 26) + kWide * kText * static_cast<double>(letters(entry.name)) + 24;
    if (x > kMargin && x + wide > chart.width - kMargin) x = kMargin, y += row;
    entry.x = x;
    entry.y = y;
    x += wide;
  }
  const double high = layout.legend.empty() ? 0 : y + row;
  layout.bottom = chart.height - kMargin * 0.6 - high;
  for (Entry& entry : layout.legend) entry.y += layout.bottom + row / 2;
  return layout;
}

PlotArea area_in(const Chart& chart, const Layout& layout, std::size_t panel) {
  const std::size_t columns = std::max<std::size_t>(1, chart.columns);
  const std::size_t rows = std::max<std::size_t>(1, (chart.panels.size() + columns - 1) / columns);
  const double wide = (chart.width - kMargin) / static_cast<double>(columns);
  const double high = (layout.bottom - layout.top) / static_cast<double>(rows);
  const double left = kMargin / 2 + wide * static_cast<double>(panel % columns);
  const double top = layout.top + high * static_cast<double>(panel / columns);
  const Panel& p = chart.panels[panel];
  return {left + (p.y.label.empty() ? 50 : 76), top + (p.title.empty() ? 10 : 28), left + wide - 16,
          top + high - (p.x.label.empty() ? 30 : 54)};
}

}  // namespace chart_layout

namespace {

// The axis's own limits, or those of the data with `margin` (a share of the range) around them.
std::pair<double, double> range_of(const Axis& axis, std::pair<double, double> data,
                                   double margin) {
  auto [low, high] = data;
  if (!(low <= high)) low = axis.log ? 1 : 0, high = axis.log ? 10 : 1;
  if (axis.log) {
    const double pad = margin * std::max(std::log10(high / low), 0.3);
    low /= std::pow(10, pad), high *= std::pow(10, pad);
  } else {
    const double pad = margin * (high > low ? high - low : std::max(std::abs(high), 1.0));
    low -= pad, high += pad;
  }
  return {std::isnan(axis.minimum) ? low : axis.minimum,
          std::isnan(axis.maximum) ? high : axis.maximum};
}

void widen(std::pair<double, double>& range, bool log, std::initializer_list<double> values) {
  for (const double v : values) {
    if (!std::isfinite(v) || (log && v <= 0)) continue;
    range = {std::min(range.first, v), std::max(range.second, v)};
  }
}

std::pair<double, double> full_range(const Panel& panel, bool horizontal) {
  const Axis& axis = horizontal ? panel.x : panel.y;
  std::pair<double, double> range{INFINITY, -INFINITY};
  for (const Series& series : panel.series) {
    for (const Point& p : series.points) {
      if (horizontal)
        widen(range, axis.log, {p.x, p.x_low, p.x_high});
      else
        widen(range, axis.log, {p.y, p.y_low, p.y_high});
    }
  }
  for (const Cell& cell : panel.cells) {
    if (horizontal)
      widen(range, axis.log, {cell.x_low, cell.x_high});
    else
      widen(range, axis.log, {cell.y_low, cell.y_high});
  }
  return range_of(axis, range, panel.cells.empty() ? 0.05 : 0);
}

}  // namespace

PlotArea plot_area(const Chart& chart, std::size_t panel) {
  return chart_layout::area_in(chart, chart_layout::layout_of(chart), panel);
}

std::pair<double, double> x_range(const Panel& panel) {
  return full_range(panel, true);
}
std::pair<double, double> y_range(const Panel& panel) {
  return full_range(panel, false);
}

}  // namespace taut::chart
