// glTF files, checked and reduced to what a model uses.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenes/model/model.h"
#include "scenes/model/named_files.h"

namespace taut::scenes {

/// A glTF file, checked and reduced.
struct CheckedGltf {
  std::string glb;
  std::vector<Texture> textures;
  std::vector<int> texture_of;        // for each material the texture of its colour, or -1
  std::vector<Animation> animations;  // their bones are indices into `nodes`
  std::vector<std::string> nodes;     // names in the GLB
  std::vector<std::string> left_out;  // what it held besides, a line each
};

/// `content` of a .glb or .gltf file as one self-contained GLB that holds only triangles, skins,
/// nodes, material factors and the places that these have on textures, and its animations, with
/// every offset, count and index of the original proved to be in range: the importer never sees a
/// structure that lies. Buffers that the file names come from `files`; nothing where that wants
/// some. Throws BadAsset.
std::optional<CheckedGltf> checked_gltf(const std::filesystem::path& file,
                                        const std::string& content, NamedFiles& files);

}  // namespace taut::scenes
