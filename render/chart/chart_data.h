// The content of a chart, and its style.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace taut::chart {

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

}  // namespace taut::chart
