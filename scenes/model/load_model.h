// Reading a model from a file, in a process of its own.
#pragma once

#include <filesystem>

#include "scenes/model/model.h"

namespace taut::scenes {

/// Reads a glTF/GLB, OBJ or BVH file, and the files that it names. All of them must lie in the
/// folder `within` (canonical; empty: the model's own), links included. Throws BadAsset, which
/// names the file and the cause, for anything missing, outside, truncated, too large, inconsistent
/// or not finite.
Model load_model(const std::filesystem::path& file, const std::filesystem::path& within = {});

/// The same in this process, for tests that look into the reader.
Model load_model_here(const std::filesystem::path& file, const std::filesystem::path& within = {});

}  // namespace taut::scenes
