// taut check: all faults of a scene, and warnings of likely mistakes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenes/files/error.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

struct Faults {
  std::vector<SceneFault> first;        // at most FirstFaults::kMost, in the order of the file
  std::optional<std::size_t> more = 0;  // how many others; without a value: not looked for
};

/// The faults of a scene and its assets, without those that only follow from another; faults that
/// another hides may be missing. Empty: load_scene() reads it.
Faults faults_of(const std::filesystem::path& file, const std::vector<SceneChange>& changes = {});

// Warnings: features of a scene that are no faults, but hardly meant.

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
