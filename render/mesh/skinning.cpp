#include "render/mesh/skinning.h"

namespace taut::mesh {

std::vector<BoneMatrix> bone_matrices(const scenes::Model& model, std::span<const Pose> bones) {
  std::vector<BoneMatrix> matrices(model.bones.size());
  for (std::size_t i = 0; i < matrices.size(); ++i) {
    Eigen::Matrix4f world = Eigen::Matrix4f::Identity();
    world.topLeftCorner<3, 3>() = bones[i].rotation.toRotationMatrix().cast<float>();
    world.topRightCorner<3, 1>() = bones[i].position.cast<float>();
    const Eigen::Matrix4f m = world * model.bones[i].inverse_bind;
    Eigen::Map<Eigen::Matrix<float, 3, 4, Eigen::RowMajor>>(matrices[i].data()) = m.topRows<3>();
  }
  return matrices;
}

void skin(const scenes::Mesh& mesh, std::span<const BoneMatrix> bones,
          std::vector<MovingVertex>& out) {
  out.resize(mesh.vertices.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const scenes::Vertex& v = mesh.vertices[i];
    BoneMatrix m{};
    for (std::size_t k = 0; k < 4; ++k) {
      const float weight = v.weights[k];
      if (weight == 0) continue;
      const BoneMatrix& bone = bones[v.bones[k]];
      for (std::size_t e = 0; e < 12; ++e) m[e] += weight * bone[e];
    }
    const auto& [x, y, z] = v.position;
    const auto& [nx, ny, nz] = v.normal;
    const float total = v.weights[0] + v.weights[1] + v.weights[2] + v.weights[3];
    if (total == 0) {
      out[i] = {{x, y, z}, {nx, ny, nz}};
      continue;
    }
    out[i].position = {m[0] * x + m[1] * y + m[2] * z + m[3], m[4] * x + m[5] * y + m[6] * z + m[7],
                       m[8] * x + m[9] * y + m[10] * z + m[11]};
    out[i].normal = {m[0] * nx + m[1] * ny + m[2] * nz, m[4] * nx + m[5] * ny + m[6] * nz,
                     m[8] * nx + m[9] * ny + m[10] * nz};
  }
}

}  // namespace taut::mesh
