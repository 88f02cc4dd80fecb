// Scoring many settings of many methods within a given time.
#pragma once

#include <vector>

#include "render/cli/accuracy_page.h"
#include "render/cli/journal.h"
#include "render/cli/study_target.h"

namespace taut::cli {

/// Scores every candidate of every contender, cheap ones first, within equal shares of `seconds`.
/// Rows that the journal holds are taken from it, others added; null: there is none.
void score_all(AccuracyStudy& study, const Target& target, const std::vector<Metric>& metrics,
               double seconds, bool quick, Journal* journal, bool quiet);

/// Times the fronts again and again, and once they are known well all others a few times, in turn,
/// until `seconds` are over; those that take more than `slow` seconds less often, for they would
/// eat the time of all others.
void time_all(AccuracyStudy& study, const Target& target, std::size_t metrics, double seconds,
              double slow);

}  // namespace taut::cli
