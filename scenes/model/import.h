// The reader of a model's bytes, in the process that calls it.
#pragma once

#include <filesystem>
#include <string>

#include "scenes/model/model.h"

namespace taut::scenes {

/// The model that `content` of a .glb, .gltf or .obj file describes; the ending of `file` says
/// which. Files that it names are read from beside `file`. Throws BadAsset.
Model import_model(const std::filesystem::path& file, const std::string& content);

}  // namespace taut::scenes
