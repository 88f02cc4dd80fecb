// Charts: curves with spreads, and maps of classes, drawn by gnuplot.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "render/chart/chart_data.h"
#include "render/chart/chart_layout.h"

namespace taut::chart {

/// The fixed styles of the methods, by their place in the list of methods; repeats after eleven.
Style method_style(std::size_t index);
/// The style of the reference that methods are scored against.
Style truth_style();

/// The picture's bytes. Throws CannotWrite where gnuplot is missing or refuses.
std::string draw_chart(const Chart& chart, ChartFormat format);

/// Writes BASE.svg and BASE.png, each complete or not at all. Throws CannotWrite.
void write_chart(const Chart& chart, const std::filesystem::path& base);

}  // namespace taut::chart
