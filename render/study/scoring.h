// Scoring many settings of many methods within a given time.
#pragma once

#include <string>
#include <vector>

#include "render/program/journal.h"
#include "render/study/accuracy_page.h"
#include "render/study/study_target.h"

namespace taut::studies {

/// The key of a candidate's row in a journal.
std::string score_key(const MethodChoice& candidate);

/// The candidates of all contenders, in the order in which they are scored.
std::vector<MethodChoice> all_candidates(const AccuracyStudy& study, bool quick);

/// The CPU time (s) that one run may take where scoring may take `seconds`.
double cap_of_a_run(const AccuracyStudy& study, double seconds);

/// A candidate's row as a journal has it, scored within a CPU time of `cap` (s) and timed a few
/// times, less often where it takes more than `slow` (s).
std::vector<std::string> scored_and_timed(const Target& target,
                                          const std::vector<study::Metric>& metrics,
                                          const MethodChoice& candidate, double cap, double slow);

/// The row that a journal has so.
study::AccuracyRow row_from(const MethodChoice& candidate, const std::vector<std::string>& cells);

/// Scores every candidate of every contender, cheap ones first, within equal shares of `seconds`.
/// Rows that the journal holds are taken from it, others added; null: there is none.
void score_all(AccuracyStudy& study, const Target& target,
               const std::vector<study::Metric>& metrics, double seconds, bool quick,
               program::Journal* journal, bool quiet);

/// Times the fronts again and again, and once they are known well all others a few times, in turn,
/// until `seconds` are over; those that take more than `slow` seconds less often, for they would
/// eat the time of all others.
void time_all(AccuracyStudy& study, const Target& target, std::size_t metrics, double seconds,
              double slow);

}  // namespace taut::studies
