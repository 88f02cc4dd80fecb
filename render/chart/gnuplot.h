// The program that draws charts.
#pragma once

#include <string>
#include <vector>

#include "render/chart/chart.h"

namespace taut::chart {

/// What gnuplot plots for a chart, in its order: names of series and of kinds of cells, empty for
/// what stands for nothing.
std::vector<std::string> plot_names(const Chart& chart);

/// Throws CannotWrite unless gnuplot can be run: to be called before a long study.
void require_gnuplot();

}  // namespace taut::chart
