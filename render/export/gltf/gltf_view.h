// Cameras and the key light of a stage as nodes of a glTF file.
#pragma once

#include "render/export/gltf/gltf_motion.h"
#include "render/export/looks.h"

namespace taut::exporting {

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

}  // namespace taut::exporting
