// The runs behind a chart of speed against accuracy.
#pragma once

#include "render/program/part.h"
#include "render/study/accuracy_page.h"
#include "render/study/study_target.h"

namespace taut::studies {

// Shares of a study's budget: most of the time finds errors, the rest repeats timings. And the
// share beyond which a run is timed less often.
inline constexpr double kScoring = 0.6, kTiming = 0.4, kSlow = 0.002;

/// The length (m) of the scene's first connector, by which errors are measured. Throws Misuse where
/// it has none.
double scored_length(const scenes::Scene& scene);

/// The least error, as a share of the length, that a study of so many settings scores.
double least_share(bool quick);

/// The truth of the scene for errors from `share` of the length up. Throws Misuse where nothing is
/// predictable.
Target scored_target(const scenes::Scene& scene, double share);

/// Shares of the length and, where the scene has a camera, pixels.
std::vector<study::Metric> accuracy_metrics(const scenes::Scene& scene);

/// The study that the options ask for, without rows.
AccuracyStudy accuracy_study(const options::StudyOptions& options, const scenes::Scene& scene);

/// Scores and times every candidate within `budget` (s). Rows that the journal holds are taken from
/// it; null: there is none.
void measure(AccuracyStudy& study, const Target& target, const std::vector<study::Metric>& metrics,
             double budget, bool quick, program::Journal* journal, bool quiet);

/// Takes all rows from the merged journal of parts.
void merge_rows(AccuracyStudy& study, const std::vector<study::Metric>& metrics, bool quick,
                program::Journal& journal);

}  // namespace taut::studies
