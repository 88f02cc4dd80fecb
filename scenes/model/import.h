// The reader of a model's bytes, in the process that calls it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "scenes/model/model.h"
#include "scenes/model/named_files.h"

namespace taut::scenes {

/// The model that `content` of a .glb, .gltf, .obj or .bvh file describes; the ending of `file`
/// says which. Opens no file: those that it names come from `files`; nothing where that wants some.
/// Throws BadAsset.
std::optional<Model> import_model(const std::filesystem::path& file, const std::string& content,
                                  NamedFiles& files);

}  // namespace taut::scenes
