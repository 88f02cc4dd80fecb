// glTF files, checked and reduced to what a model uses.
#pragma once

#include <filesystem>
#include <string>

namespace taut::scenes {

/// `content` of a .glb or .gltf file as one self-contained GLB that holds only triangles, skins,
/// nodes and material factors, with every offset, count and index of the original proved to be in
/// range: the importer never sees a structure that lies. Buffers that the file names are read from
/// beside it. Throws BadAsset.
std::string checked_glb(const std::filesystem::path& file, const std::string& content);

}  // namespace taut::scenes
