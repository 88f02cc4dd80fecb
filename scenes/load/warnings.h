// Warnings: features of a scene that are no faults, but hardly meant.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene/scene.h"

namespace taut::scenes {

/// Where a hand's path is out of its arm's reach, what the camera does not show and when, and
/// whether anything is simulated at all; a sentence each. The scene has its stage complete or none.
/// Simulates for at most `seconds` of CPU time: a warning says what is left out.
std::vector<std::string> warnings_of(const Scene& scene, double seconds,
                                     const std::function<void()>& tick);

/// By how much the path that stands in a scene misses what its choreography asks for, where that is
/// too much; else nothing. `changes` are those that the scene was read with. Throws BadScene.
std::optional<std::string> choreography_warning(const Scene& scene,
                                                const std::vector<SceneChange>& changes);

}  // namespace taut::scenes
