// What runs of a study are judged by: the truth of a scene, and units to judge in.
#pragma once

#include <optional>

#include "scenes/scene.h"
#include "sim/study/accuracy.h"
#include "sim/study/reference.h"
#include "sim/study/run.h"
#include "sim/truth/truth.h"

namespace taut::cli {

/// A problem up to where its truth is predictable, and that truth.
struct Target {
  Problem problem;
  Reference reference;
};

/// The scene's frames of its first `duration` seconds, cut at the horizon.
Target target_of(const Scene& scene, double duration, const TruthOptions& options);

/// Distance on the picture of the scene's camera, px; none where the scene has no stage. A point
/// behind the camera is infinitely far from where it should be.
std::optional<Metric> pixels_of(const Scene& scene);

}  // namespace taut::cli
