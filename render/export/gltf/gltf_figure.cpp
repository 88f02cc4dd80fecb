#include "render/export/gltf/gltf_figure.h"

namespace taut::exporting {

GltfFigure::GltfFigure(GltfFile& file, GltfMeshes& meshes, const std::string& name,
                       const scenes::Model& model)
    : model_(model) {
  const std::size_t group = file.add_node(name);
  for (const scenes::Bone& bone : model.bones)
    bones_.push_back(
        file.add_node(bone.name, bone.parent < 0 ? group : bones_[std::size_t(bone.parent)]));
  std::vector<std::size_t> joints = bones_;
  std::vector<float> inverse_bind;
  for (const scenes::Bone& bone : model.bones) {
    Eigen::Matrix4f m = bone.inverse_bind;
    m.row(3) << 0, 0, 0, 1;
    inverse_bind.insert(inverse_bind.end(), m.data(), m.data() + m.size());
  }
  if (GltfMeshes::has_fixed_vertices(model)) {
    joints.push_back(group);
    const Eigen::Matrix4f none = Eigen::Matrix4f::Identity();
    inverse_bind.insert(inverse_bind.end(), none.data(), none.data() + none.size());
  }
  const std::size_t skin = file.add(
      "skins", {{"name", name},
                {"inverseBindMatrices",
                 file.add_numbers(std::span<const float>(inverse_bind), {GltfFile::f32, "MAT4"})},
                {"skeleton", group},
                {"joints", joints}});
  const std::size_t node = file.add_node(name + " skin");
  file.node(node)["mesh"] = meshes.of_model(model);
  file.node(node)["skin"] = skin;
}

void GltfFigure::pose(std::span<const Pose> bones, GltfMotion& motion) const {
  for (std::size_t i = 0; i < bones_.size(); ++i) {
    const int parent = model_.bones[i].parent;
    const Pose above = parent < 0 ? Pose() : bones[std::size_t(parent)];
    const Quat back = above.rotation.conjugate();
    motion.translate(bones_[i], back * (bones[i].position - above.position));
    motion.turn(bones_[i], back * bones[i].rotation);
  }
}

}  // namespace taut::exporting
