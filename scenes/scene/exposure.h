// Which of a simulation's states a frame shows while its shutter is open.
#pragma once

#include <vector>

#include "scenes/scene/scene.h"

namespace taut::scenes {

/// The times (s) of the states that the frame at `time` is made of, evenly apart while the shutter
/// is open, the frame's own in the middle (the later one of two); `time` alone where the scene has
/// no shutter. `rate` is how fast the clip goes, in seconds of the scene to one of the clip.
///
/// The number of times is Stage::exposures, or the power of two that the method's steps suffice
/// for: methods of equal steps stop after their own steps, so that the shutter changes no bit of
/// the trajectory. Times before the scene's start become the start.
std::vector<double> exposure_times(const Scene& scene, double time, double rate = 1);

/// The time nearest to `time` (s) at which the scene's method ends a step by itself. Methods that
/// choose their steps end one anywhere; times are rounded for them, to far below a frame.
double own_time(const Scene& scene, double time);

}  // namespace taut::scenes
