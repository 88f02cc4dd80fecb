// All that is wrong with a scene, for people who mend it.
#pragma once

#include <filesystem>
#include <vector>

#include "scenes/files/fault.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

/// Every fault of a scene and of its assets, in the order of the file: what follows only from
/// another fault is left out, and what another hides may be. Empty: load_scene() reads it.
std::vector<SceneFault> faults_of(const std::filesystem::path& file,
                                  const std::vector<SceneChange>& changes = {});

}  // namespace taut::scenes
