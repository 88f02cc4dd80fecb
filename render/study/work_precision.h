// The cost of an error for each method, scene beside scene.
#pragma once

#include <vector>

#include "render/program/output.h"
#include "render/study/accuracy_page.h"

namespace taut::studies {

/// Scores and times every candidate on each of the options' scenes, for errors (m) that are all
/// asked for. The truths count towards the budget of each scene.
std::vector<AccuracyStudy> work_precision(options::StudyOptions options,
                                          const std::vector<double>& errors, bool quiet);
/// Does the options' part of these runs, and says how it ended.
int work_precision_part(const options::StudyOptions& options, const std::vector<double>& errors,
                        const program::Common& common);
/// The same studies, from the journals of all parts.
std::vector<AccuracyStudy> merged_work_precision(const options::StudyOptions& options,
                                                 const std::vector<double>& errors);

/// A row per contender; a column per scene and error: the cost, and how many times that of the
/// cheapest it is.
chart::Table costs_of_errors(const std::vector<AccuracyStudy>& studies,
                             const std::vector<double>& errors);
/// The same, a row each, with the settings that do it.
chart::Table cheapest_settings(const std::vector<AccuracyStudy>& studies,
                               const std::vector<double>& errors);
/// Why cells are empty: how near the method came, or what ended its runs.
chart::Table errors_not_attained(const std::vector<AccuracyStudy>& studies,
                                 const std::vector<double>& errors);
program::Json work_precision_json(const AccuracyStudy& study, const std::vector<double>& errors);

}  // namespace taut::studies
