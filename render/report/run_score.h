// One run against the truth: its cost and its error.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "scenes/scene/scene.h"
#include "sim/evaluation/run.h"
#include "sim/truth/reference.h"

namespace taut::report {

/// An error at a time (s), as a share of the length.
struct ErrorAt {
  double time = 0, error = 0;
};

/// RMS over the particles of each frame, up to the horizon; as far as the run came.
std::vector<ErrorAt> errors_over_time(const study::Run& run, const truth::Reference& reference,
                                      double length);

/// Scores the scene's own method down to errors of `share` of the length, as `taut chart` does. The
/// result as JSON: scene, method, settings, horizon_s, self_error, rms_error,
/// cpu_ms_per_simulated_s, diverged_at_s, errors. Throws Misuse where there is nothing to score.
nlohmann::ordered_json run_score(const scenes::Scene& scene, double share);

}  // namespace taut::report
