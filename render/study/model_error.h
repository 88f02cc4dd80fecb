// The error of few particles, whatever the method: chains of n particles against the continuous
// rope that they stand for.
#pragma once

#include <vector>

#include "render/chart/chart.h"
#include "render/chart/table.h"
#include "render/options/study_options.h"
#include "render/program/part.h"

namespace taut::studies {

struct ModelRow {
  std::size_t particles = 0;
  double links = 0;  // RMS error of the chain of rigid links, a share of the length
  double span = 0;   // of the massless span, the model that `impulse` converges to
  double cost = 0;   // CPU s per simulated second of the direct method
};

struct ModelStudy {
  double until = 0;        // s; later the continuous rope is not known well enough
  double uncertainty = 0;  // RMS, share of the length, of the continuous rope
  std::vector<ModelRow> rows;
};

/// Errors of 6 to 161 particles over the first `duration` seconds. The continuous rope is what
/// chains of 161 and 321 particles tend to: their errors fall with 1/n, since every particle has
/// the mass m/n. Rows that the journal knows are not run again. `done` is called after each run.
ModelStudy model_study(const options::StudyOptions& options, double duration,
                       program::Journal& journal);

/// The runs that a model study makes, by the keys of their rows; and the row of the `index`-th.
std::vector<std::string> model_keys();
std::vector<std::string> model_row(const options::StudyOptions& options, double duration,
                                   std::size_t index);

chart::Table model_table(const ModelStudy& study);
chart::Chart model_chart(const ModelStudy& study, const std::string& title);

}  // namespace taut::studies
