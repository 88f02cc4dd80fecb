// From the importer's structures to a Model.
#pragma once

#include <filesystem>

#include "scenes/model/model.h"

struct aiScene;

namespace taut::scenes {

/// Every mesh of the scene in model space, its materials, and the nodes of its skeleton. Throws
/// BadAsset for values that no model may hold.
Model from_imported(const std::filesystem::path& file, const aiScene& scene);

}  // namespace taut::scenes
