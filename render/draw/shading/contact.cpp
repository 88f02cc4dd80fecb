#include "render/draw/shading/contact.h"

#include <Eigen/LU>

namespace taut::draw {

Eigen::AlignedBox3f ContactCapsule::bounds() const {
  const Vec3 far = Vec3::Constant(kContactRange * radius);
  return Eigen::AlignedBox3d(from.cwiseMin(to) - far, from.cwiseMax(to) + far).cast<float>();
}

namespace {

/// Where a foot points on the floor in the bind pose, in the frame of its toes' bone.
Vec3 toes_ahead(const scenes::Model& character, std::size_t toes) {
  const auto bind = [&](std::size_t bone) {
    return character.bones[bone].inverse_bind.cast<double>().eval();
  };
  const auto place = [&](std::size_t bone) {
    return Vec3(bind(bone).inverse().topRightCorner<3, 1>());
  };
  Vec3 ahead = place(toes) - place(std::size_t(character.bones[toes].parent));
  ahead.y() = 0;
  return bind(toes).topLeftCorner<3, 3>() * ahead.normalized();
}

}  // namespace

std::vector<ContactCapsule> feet(const scenes::Model& character, const std::vector<Pose>& bones) {
  constexpr double kFoot = 0.055, kToes = 0.016, kToe = 0.06;  // m: radii, and toes' length
  std::vector<ContactCapsule> capsules;
  for (std::size_t i = 0; i < bones.size(); ++i) {
    const scenes::Bone& bone = character.bones[i];
    if (bone.parent < 0 || !bone.name.ends_with("ToeBase")) continue;
    const Vec3 ankle = bones[std::size_t(bone.parent)].position, ball = bones[i].position;
    const Vec3 ahead = bones[i].rotation * toes_ahead(character, i);
    capsules.push_back({ankle, ball, kFoot});
    capsules.push_back({ball, ball + kToe * ahead, kToes});
  }
  return capsules;
}

std::vector<ContactCapsule> shins(const scenes::Model& character, const std::vector<Pose>& bones) {
  constexpr double kShin = 0.06;  // m
  std::vector<ContactCapsule> capsules;
  for (std::size_t i = 0; i < bones.size(); ++i) {
    const int ankle = character.bones[i].parent;
    if (ankle < 0 || !character.bones[i].name.ends_with("ToeBase")) continue;
    const int knee = character.bones[std::size_t(ankle)].parent;
    if (knee < 0) continue;
    capsules.push_back(
        {bones[std::size_t(knee)].position, bones[std::size_t(ankle)].position, kShin});
  }
  return capsules;
}

std::vector<scenes::Capsule> arms(const scenes::Model& character) {
  std::vector<scenes::Capsule> capsules = scenes::fit_capsules(character);
  std::erase_if(capsules, [&](const scenes::Capsule& c) {
    return !character.bones[c.bone].name.ends_with("Arm");
  });
  return capsules;
}

std::optional<ContactCapsule> rod(const scenes::Model& model) {
  Eigen::AlignedBox3d box;
  for (const scenes::Mesh& mesh : model.meshes)
    for (const scenes::Vertex& v : mesh.vertices)
      box.extend(Eigen::Vector3f(v.position.data()).cast<double>());
  if (box.isEmpty()) return {};
  int axis = 0;
  const double length = box.sizes().maxCoeff(&axis);
  Vec3 across = box.sizes();
  across[axis] = 0;
  const double radius = across.maxCoeff() / 2;
  if (length < 4 * radius) return {};
  const Vec3 half = (length / 2 - radius) * Vec3::Unit(axis);
  return ContactCapsule{box.center() - half, box.center() + half, radius};
}

}  // namespace taut::draw
