// The results of `taut chart` as tables, a chart and a page.
#pragma once

#include <string>
#include <vector>

#include "render/cli/study_options.h"
#include "sim/study/speed_accuracy.h"

namespace taut::cli {

struct AccuracyBlock {
  Contender contender;
  std::vector<AccuracyRow> rows;  // empty: not in this build
};

struct AccuracyStudy {
  std::string scene, title;
  std::size_t particles = 0;
  double horizon = 0;           // s
  double self_error = 0;        // of the length
  std::vector<double> targets;  // of the length
  std::vector<AccuracyBlock> blocks;
};

/// Every run: settings, error, cost, steps, how it ended.
Table points_table(const AccuracyStudy& study);
/// Per method, the cheapest cost that reaches each target, and the settings that do.
Table reach_table(const AccuracyStudy& study);
/// Fronts as lines, what they dominate as faint markers.
Chart accuracy_chart(const AccuracyStudy& study);
/// One HTML page that needs no other file.
std::string accuracy_page(const AccuracyStudy& study, const std::string& svg);
std::string accuracy_json(const AccuracyStudy& study);

}  // namespace taut::cli
