// From the importer's structures to a Model.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "scenes/model/model.h"

struct aiScene;

namespace taut::scenes {

/// Textures, and which one the colour of a material has.
struct Textures {
  std::vector<Texture> all;
  std::vector<int> of_material;        // by the material's index; -1: none
  std::map<std::string, int> of_name;  // by its name
};

/// Animations, whose bones are indices into the names of nodes.
struct NodeAnimations {
  std::vector<Animation> all;
  std::vector<std::string> nodes;
};

/// Every mesh of the scene in model space, its materials, and the nodes of its skeleton, which are
/// those that skins name or animations move. Throws BadAsset for values that no model may hold.
/// Meshes without normals get those of their faces where `flat`, else means of these at each
/// vertex.
Model from_imported(const std::filesystem::path& file, const aiScene& scene, bool flat,
                    Textures textures, NodeAnimations animations);

}  // namespace taut::scenes
