// The program that draws charts.
#pragma once

#include <string>
#include <vector>

#include "render/base/child.h"
#include "render/chart/chart_data.h"

namespace taut::chart {

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
