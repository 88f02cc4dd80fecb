// The target that runs of a study are scored against: the truth of a scene, in units of choice.
#pragma once

#include <optional>
#include <span>

#include "scenes/scene/scene.h"
#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/truth/truth.h"

namespace taut::studies {

/// A problem up to where its truth is predictable, and that truth.
struct Target {
  study::Problem problem;
  truth::Reference reference;
};

/// The truth of a scene at times (s). Says how far it is on a terminal.
truth::Reference solved_truth(const scenes::Scene& scene, std::span<const double> times,
                              const truth::TruthOptions& options);

/// The scene's frames of its first `duration` seconds, cut at the horizon.
Target target_of(const scenes::Scene& scene, double duration, const truth::TruthOptions& options);

/// The whole scene up to its horizon. Throws Misuse where that is before the second frame.
Target predictable_target(const scenes::Scene& scene, const truth::TruthOptions& options);

/// The same by truth::stepped_reference().
Target stepped_target(const scenes::Scene& scene, double step, double scored_error);

/// The truth as far as it tells runs within `scored_error` (m) from others. None where one of its
/// solvers cannot solve the problem within `cpu_cap` (s), or they disagree at once.
std::optional<truth::Reference> quick_reference(const study::Problem& problem, double scored_error,
                                                double cpu_cap);

/// Distance on the picture, px, the largest of any shot that shows the time; none where the scene
/// has no stage. A point behind the camera is infinitely far from where it should be. Copies may be
/// used at once, one by each thread.
std::optional<study::Metric> pixels_of(const scenes::Scene& scene);

}  // namespace taut::studies
