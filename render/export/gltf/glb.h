// Scenes as animated binary glTF 2.0.
#pragma once

#include "render/export/frame_writer.h"
#include "render/export/gltf/gltf_mesh.h"
#include "render/export/gltf/gltf_motion.h"
#include "scenes/character/skeleton.h"

namespace taut::exporting {

/// Bodies, characters, connectors, scenery, cameras and the key light. A particle's node is where
/// the simulation had it: to float's rounding at every frame, and within 0.1 mm between. The scene
/// may be without a stage, but must outlive the writer. Throws BadScene where a connector has more
/// particles than a skin has joints.
std::unique_ptr<FrameWriter> glb_writer(const scenes::Scene& scene, WriteBytes write);

// Cameras and the key light of a stage as nodes of a glTF file.

class GltfView {
 public:
  GltfView(GltfFile& file, const scenes::Scene& scene);

  /// Places the cameras as they are at `time` (s), the next key.
  void place(double time, GltfMotion& motion) const;

 private:
  struct Camera {
    std::size_t node;
    NamedCamera camera;
  };
  std::vector<Camera> cameras_;
};

// A character as a skin and a skeleton of a glTF file.

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
