// Warnings: features of a scene that are no faults, but hardly meant.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenes/scene/scene.h"

namespace taut::scenes {

/// Where a hand's path is out of its arm's reach, what the camera does not show and when, and
/// whether anything is simulated at all; a sentence each. The scene has its stage complete or none.
/// Simulates for at most `seconds` of wall time: later motion is not looked at.
std::vector<std::string> warnings_of(const Scene& scene, double seconds,
                                     const std::function<void()>& tick);

}  // namespace taut::scenes
