// Meshes of models and connectors as glTF has them.
#pragma once

#include <map>

#include "render/export/gltf/gltf_file.h"
#include "render/mesh/connector_mesh.h"
#include "scenes/model/model.h"

namespace taut::exporting {

class GltfMeshes {
 public:
  explicit GltfMeshes(GltfFile& file) : file_(file) {}

  /// The mesh of a model, one primitive for each of its materials; made once. A vertex that no bone
  /// moves belongs to the joint behind the last bone; none where nothing is skinned.
  std::size_t of_model(const scenes::Model& model);
  /// True where some vertices of a skinned model have no bone.
  static bool has_fixed_vertices(const scenes::Model& model);

  /// One primitive, `joints` and `weights` empty where nothing is skinned.
  std::size_t of_mesh(const std::string& name, const scenes::Mesh& mesh,
                      const scenes::Material& material, bool skinned);

 private:
  GltfFile::Json primitive(const scenes::Mesh& mesh, const scenes::Material& material, bool skinned,
                           std::size_t fixed_joint);
  std::size_t material(const scenes::Material& material, const std::array<float, 3>& tint);

  GltfFile& file_;
  std::map<const scenes::Model*, std::size_t> models_;
  std::map<std::string, std::size_t> materials_;  // by what they say
};

/// Vertices that move, at rest, as a mesh without bones.
scenes::Mesh plain_mesh(std::span<const mesh::MovingVertex> vertices,
                        std::span<const std::uint32_t> indices, const Eigen::Vector3f& color);

}  // namespace taut::exporting
