// Where everything of a chart lies, in px from the upper left of the picture.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/chart/chart_data.h"

namespace taut::chart {

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
}  // namespace taut::chart
