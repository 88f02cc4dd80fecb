// A character as a skin and a skeleton of a glTF file.
#pragma once

#include "render/export/gltf/gltf_mesh.h"
#include "render/export/gltf/gltf_motion.h"
#include "scenes/character/performance.h"

namespace taut::exporting {

class GltfFigure {
 public:
  GltfFigure(GltfFile& file, GltfMeshes& meshes, const std::string& name,
             const scenes::Model& model);

  /// Poses the skeleton as it is at the next key; poses in the world, one for each of the bones.
  void pose(std::span<const Pose> bones, GltfMotion& motion) const;

 private:
  const scenes::Model& model_;
  std::vector<std::size_t> bones_;  // nodes
};

}  // namespace taut::exporting
