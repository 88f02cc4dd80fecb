// A connector as nodes of a glTF file: one for each particle, and what is seen of it.
#pragma once

#include "render/export/gltf/gltf_mesh.h"
#include "render/export/gltf/gltf_motion.h"
#include "render/mesh/chain_mesh.h"
#include "scenes/scene/stage.h"

namespace taut::exporting {

class GltfConnector {
 public:
  /// A chain's links hang on the particles at which they begin; the tube of a rope or cord is
  /// skinned to its particles. `bodies` are the nodes of the bodies, `models` what these look like.
  GltfConnector(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                const scenes::ConnectorLook& look, std::span<const std::size_t> bodies,
                std::span<const std::shared_ptr<const scenes::Model>> models);

  /// The nodes of the particles, for whoever moves them.
  const std::vector<std::size_t>& particles() const { return particles_; }

  /// Those of them that are joints of a tube: their own places are those of its mesh as it is made.
  std::span<const std::size_t> joints() const {
    return links_.empty() ? std::span<const std::size_t>(particles_)
                          : std::span<const std::size_t>();
  }

  /// Turns particles or links as they are at the next key.
  void turn(std::span<const Vec3> particles, std::span<const Pose> bodies, GltfMotion& motion);

 private:
  struct Link {
    std::size_t node, particle;  // the particle at or before its beginning
    bool off;                    // it begins behind that
  };
  void add_chain(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                 const scenes::ConnectorLook& look, std::span<const std::size_t> bodies,
                 std::span<const std::shared_ptr<const scenes::Model>> models);
  void add_tube(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                const scenes::ConnectorLook& look);
  void turn_links(std::span<const Vec3> particles, std::span<const Pose> bodies,
                  GltfMotion& motion) const;
  void turn_particles(std::span<const Vec3> particles, GltfMotion& motion);

  std::vector<std::size_t> particles_;
  std::vector<Link> links_;  // empty: a tube
  std::array<std::optional<mesh::ChainMount>, 2> mounts_;
  Vec3 axis_ = Vec3::UnitY(), side_ = Vec3::UnitX();  // of the tube's beginning at the last key
};

}  // namespace taut::exporting
