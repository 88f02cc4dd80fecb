// Charts: curves with spreads, and maps of classes, drawn by gnuplot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "render/base/child.h"

namespace taut::chart {

// The content of a chart, and its style.

/// How a curve looks. Every style differs from the others in colour, in grey, in dash and in
/// marker.
struct Style {
  std::uint32_t color = 0;  // 0xRRGGBB
  int dash = 0;             // index into the list of dash patterns
  int marker = 0;           // index into the list of markers
  bool hollow = false;      // markers drawn as outlines: a second form of the same thing

  bool operator==(const Style&) const = default;
};

inline constexpr double kAuto = std::numeric_limits<double>::quiet_NaN();

struct Axis {
  std::string label;  // with the unit
  bool log = false;
  double minimum = kAuto, maximum = kAuto;                // kAuto: from the data
  std::vector<std::pair<double, std::string>> tics = {};  // empty: chosen from the range
};

/// A point with its spread; not-a-number breaks the line.
struct Point {
  double x = 0, y = 0;
  double x_low = kAuto, x_high = kAuto, y_low = kAuto, y_high = kAuto;
  std::string command = {};  // that makes it; pages show it
};

struct Series {
  std::string name;  // empty: not in the legend
  Style style;
  bool line = true;
  bool markers = true;
  bool faint = false;
  std::vector<Point> points;
};

/// A rectangle of a map, in the axes' values, and the class that fills it.
struct Cell {
  double x_low = 0, x_high = 0, y_low = 0, y_high = 0;
  std::size_t kind = 0;      // index into Chart::kinds
  double x = 0, y = 0;       // what it stands for
  std::string command = {};  // that makes it; pages show it
};

struct CellKind {
  std::string name;
  std::string letter;  // drawn in the cell, for readers without colour
  std::uint32_t color = 0xffffff;
};

/// A straight line over the whole panel; left out where it lies outside the axes. The label of a
/// horizontal one stands at the end where fewer curves cross it.
struct Rule {
  double at = 0;
  bool vertical = true;
  std::string label;
};

/// Text inside a panel, in shares of its width and height from the lower left.
struct Remark {
  double x = 0.5, y = 0.5;
  std::string text;
};

struct Panel {
  std::string title;
  Axis x, y;
  std::vector<Series> series;
  std::vector<Cell> cells;
  std::vector<Rule> rules;
  std::vector<Remark> remarks;
};

struct Chart {
  std::string title;  // the finding, in a sentence
  std::string subtitle;
  std::vector<Panel> panels;
  std::size_t columns = 1;
  std::vector<CellKind> kinds;
  int width = 1100, height = 700;  // px
  bool legend = true;
};

/// The rectangle inside a panel's axes, in px from the upper left of the picture.
struct PlotArea {
  double left = 0, top = 0, right = 0, bottom = 0;
};

enum class ChartFormat { svg, png };

// Where everything of a chart lies, in px from the upper left of the picture.

/// Where a panel's axes lie in the picture.
PlotArea plot_area(const Chart& chart, std::size_t panel);
/// The range of a panel's axis as drawn.
std::pair<double, double> x_range(const Panel& panel);
std::pair<double, double> y_range(const Panel& panel);

namespace chart_layout {

inline constexpr double kText = 14, kTitle = 19;  // px, heights of the type
inline constexpr double kMargin = 18;             // px
inline constexpr double kLine = 1.35;  // line spacing, as a share of the height of the type

struct Entry {  // of the legend
  std::string name;
  const Style* style = nullptr;  // null: a swatch
  bool line = true, markers = true;
  const CellKind* kind = nullptr;
  double x = 0, y = 0;  // px from the upper left
};

struct Layout {
  std::vector<std::string> title, subtitle;
  double top = 0;     // px, below the titles
  double bottom = 0;  // px, above the legend
  std::vector<Entry> legend;
};

/// The label of a horizontal rule stands at the right end: fewer curves cross it there.
bool is_label_right(const Panel& panel, const Rule& rule);

/// A series' name; one without goes with the one that looks like it, and hides with that.
std::string name_in(const Panel& panel, const Series& series);

Layout layout_of(const Chart& chart);
PlotArea area_in(const Chart& chart, const Layout& layout, std::size_t panel);

}  // namespace chart_layout

/// The fixed styles of the methods, by their place in the list of methods; repeats after eleven.
Style method_style(std::size_t index);
/// The style of the reference that methods are scored against.
Style truth_style();

/// The picture's bytes. Throws CannotWrite where gnuplot is missing or refuses.
std::string draw_chart(const Chart& chart, ChartFormat format);

/// Writes BASE.svg and BASE.png, each complete or not at all. Throws CannotWrite.
void write_chart(const Chart& chart, const std::filesystem::path& base);

// The program that draws charts.

/// The program that gnuplot is given for the chart.
std::string gnuplot_script(const Chart& chart, ChartFormat format);

/// The plots of a chart in gnuplot's order: names of series and of kinds of cells, empty for plots
/// that have none.
std::vector<std::string> plot_names(const Chart& chart);

/// Runs gnuplot with this input. Throws CannotWrite where it cannot be run or fails.
render::ChildResult run_gnuplot(const std::vector<std::string>& command, const std::string& input);

/// Throws CannotWrite unless gnuplot can be run: to be called before a long study.
void require_gnuplot();

}  // namespace taut::chart
