// Reading a model from a file, in a process of its own.
#pragma once

#include <filesystem>

#include "scenes/model/model.h"

namespace taut::scenes {

/// Reads a glTF/GLB or OBJ file. Throws BadAsset (a message that names the file and the cause) for
/// anything that is missing, truncated, too large, inconsistent or not finite.
Model load_model(const std::filesystem::path& file);

}  // namespace taut::scenes
