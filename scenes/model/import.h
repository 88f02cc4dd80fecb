// Reads a model from bytes, in the calling process.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "scenes/model/model.h"
#include "scenes/model/named_files.h"

namespace taut::scenes {

/// The model in `content`, in the format that the ending of `file` names: .glb, .gltf, .obj or
/// .bvh. Opens no file: files that the model names come from `files`; none while `files` lacks one.
/// Throws BadAsset.
std::optional<Model> import_model(const std::filesystem::path& file, const std::string& content,
                                  NamedFiles& files);

}  // namespace taut::scenes
