// The program that draws charts.
#pragma once

#include <string>
#include <vector>

#include "render/chart/chart.h"

namespace taut::chart {

/// The names of gnuplot's plots for a chart, in order: of series and of kinds of cells, empty for
/// plots that stand for nothing.
std::vector<std::string> plot_names(const Chart& chart);

/// Throws CannotWrite unless gnuplot can be run: to be called before a long study.
void require_gnuplot();

}  // namespace taut::chart
