// Errors of recorded states against reference states at the same times.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "sim/run/trajectory.h"

namespace taut::study {

/// How far a particle at `at` is from where it should be (`truth`), both m, at `time` (s); in
/// whatever unit the metric has.
using Distance = std::function<double(const Vec3& at, const Vec3& truth, double time)>;

struct Metric {
  std::string name;  // "share of the length"
  std::string unit;  // "1", "px"
  Distance distance;
};

/// Distance as a share of `length` (m).
Metric share_of_length(double length);

/// RMS of the distance over all particles and all frames up to `horizon` (s). Infinite where
/// `frames` end before the horizon does. The particles must match; throws std::invalid_argument.
double rms_error(std::span<const Snapshot> frames, std::span<const Snapshot> truth, double horizon,
                 const Distance& distance);

/// RMS of the distance over the particles of one frame.
double frame_error(const Snapshot& frame, const Snapshot& truth, const Distance& distance);

/// Mean distance (m) of the segments' midpoints: the measure of the paper's Figure 6.
double segment_difference(const Snapshot& frame, const Snapshot& reference);

}  // namespace taut::study
