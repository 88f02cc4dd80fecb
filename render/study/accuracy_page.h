// The results of `taut chart` as tables, a chart and a page.
#pragma once

#include <string>
#include <vector>

#include "render/options/study_options.h"
#include "render/study/model_error.h"
#include "sim/study/speed_accuracy.h"

namespace taut::studies {

struct AccuracyBlock {
  options::Contender contender;
  std::vector<study::AccuracyRow> rows;  // empty: not in this build
};

struct AccuracyStudy {
  std::string scene, title;
  std::vector<std::string> set;  // of --set
  double share = 0;              // the least error that is scored, of the length
  std::size_t particles = 0;
  double horizon = 0;           // s
  double self_error = 0;        // of the length; of work_precision() m
  std::vector<double> targets;  // of the length
  bool in_pixels = false;       // rows have a second error, in pixels of the scene's camera
  std::vector<AccuracyBlock> blocks;
  double unsteadiness = 0;  // of the timings of all blocks
  ModelStudy model;         // no rows: not asked for
};

/// Every run: settings, error, cost, steps, how it ended. `exact`: errors read back as the same
/// numbers.
chart::Table points_table(const AccuracyStudy& study, bool exact);
/// Per method, the cheapest cost that reaches each target (and one pixel), and the settings that
/// do.
chart::Table work_precision_table(const AccuracyStudy& study);
/// Per target, the cheapest contender that reaches it, its settings, and the next.
chart::Table best_table(const AccuracyStudy& study);
/// The cheapest method at a middling error, in a sentence.
std::string accuracy_finding(const AccuracyStudy& study);
/// Fronts as lines, what they dominate as faint markers; a second panel in pixels where rows have
/// them.
chart::Chart accuracy_chart(const AccuracyStudy& study);
/// The study's section of a page: the chart, the methods to use, the cost of an error.
std::string accuracy_section(const AccuracyStudy& study);
/// One HTML page that needs no other file.
std::string accuracy_page(const AccuracyStudy& study);
std::string accuracy_json(const AccuracyStudy& study);

}  // namespace taut::studies
