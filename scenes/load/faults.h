// All that is wrong with a scene, for people who mend it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "scenes/files/first_faults.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

struct Faults {
  std::vector<SceneFault> first;        // at most FirstFaults::kMost, in the order of the file
  std::optional<std::size_t> more = 0;  // how many others; without a value: not looked for
};

/// The faults of a scene and its assets, without those that only follow from another; faults that
/// another hides may be missing. Empty: load_scene() reads it.
Faults faults_of(const std::filesystem::path& file, const std::vector<SceneChange>& changes = {});

}  // namespace taut::scenes
