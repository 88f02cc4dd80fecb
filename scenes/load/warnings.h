// Warnings: features of a scene that are no faults, but hardly meant.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenes/scene/scene.h"

namespace taut::scenes {

/// How many of the scene's frames it takes from one look through the camera to the next.
int frames_between_looks(const Scene& scene);

/// A run of a scene, as far as it is known.
struct KnownRun {
  std::span<const Snapshot> states;  // one for each look, from the first on
  std::string diverged;              // how it ended there; empty: it did not
};

/// Where a hand's path is out of its arm's reach, what the camera does not show and when, and
/// whether anything is simulated at all; a sentence each. The scene has its stage complete or none.
/// What the camera shows behind the known run is left out, as a warning says.
std::vector<std::string> warnings_of(const Scene& scene, const KnownRun& run);

/// By how much the path that stands in a scene misses what its choreography asks for, where that is
/// too much; else nothing. `changes` are those that the scene was read with. Throws BadScene.
std::optional<std::string> choreography_warning(const Scene& scene,
                                                const std::vector<SceneChange>& changes);

}  // namespace taut::scenes
