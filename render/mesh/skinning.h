// Linear blend skinning.
#pragma once

#include <span>
#include <vector>

#include "render/mesh/connector_mesh.h"
#include "scenes/model/model.h"

namespace taut::mesh {

/// Where a bone takes the bind pose's points: three rows of four, world space.
using BoneMatrix = std::array<float, 12>;

/// The bone matrices of a model for the world poses of its bones.
std::vector<BoneMatrix> bone_matrices(const scenes::Model& model, std::span<const Pose> bones);

/// The mesh's vertices moved by its bones; vertices without weights stay.
void skin(const scenes::Mesh& mesh, std::span<const BoneMatrix> bones,
          std::vector<MovingVertex>& out);

}  // namespace taut::mesh
