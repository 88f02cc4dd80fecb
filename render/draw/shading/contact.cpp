#include "render/draw/shading/contact.h"

namespace taut::draw {

Eigen::AlignedBox3f ContactCapsule::bounds() const {
  const Vec3 far = Vec3::Constant(kContactRange * radius);
  return Eigen::AlignedBox3d(from.cwiseMin(to) - far, from.cwiseMax(to) + far).cast<float>();
}

std::vector<ContactCapsule> feet(const scenes::Model& character, const std::vector<Pose>& bones) {
  constexpr double kFoot = 0.055;  // m
  std::vector<ContactCapsule> capsules;
  for (std::size_t i = 0; i < bones.size(); ++i) {
    const scenes::Bone& bone = character.bones[i];
    if (bone.parent < 0 || bone.name.find("Toe") == std::string::npos) continue;
    capsules.push_back({bones[std::size_t(bone.parent)].position, bones[i].position, kFoot});
  }
  return capsules;
}

}  // namespace taut::draw
