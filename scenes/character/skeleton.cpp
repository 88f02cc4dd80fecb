#include "scenes/character/skeleton.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "scenes/files/regular_file.h"

namespace taut::scenes {
namespace {

constexpr std::string_view elbow = "Elbow";

}  // namespace

Skeleton::Skeleton(const Model& model) : model_(model) {
  for (const Bone& bone : model.bones) {
    Pose world = bone.rest;
    if (bone.parent >= 0) {
      const auto p = static_cast<std::size_t>(bone.parent);
      world = {rest_[p] + rest_rotation_[p] * bone.rest.position,
               rest_rotation_[p] * bone.rest.rotation};
    }
    parent_.push_back(bone.parent);
    rest_.push_back(world.position);
    rest_rotation_.push_back(world.rotation);
    const bool halves = bone.name.ends_with(elbow);
    const std::string side = bone.name.substr(0, bone.name.size() - halves * elbow.size());
    halves_.push_back(halves ? model.bone(side + "ForeArm") : -1);
  }
}

std::size_t Skeleton::find(std::string_view name) const {
  const int index = model_.bone(name);
  if (index < 0) throw bad_asset(model_.name, fmt::format("has no bone \"{}\"", name));
  return static_cast<std::size_t>(index);
}

Posture Skeleton::upright() const {
  return {std::vector<Quat>(size(), Quat::Identity()), {0, 0, 0}};
}

Placement Skeleton::place(const Posture& posture) const {
  Placement placed{std::vector<Vec3>(size()), std::vector<Quat>(size())};
  for (std::size_t i = 0; i < size(); ++i) {
    if (parent_[i] < 0) {
      placed.position[i] = rest_[i] + posture.shift;
      placed.turn[i] = posture.turn[i];
    } else {
      const auto p = static_cast<std::size_t>(parent_[i]);
      placed.position[i] = placed.position[p] + placed.turn[p] * (rest_[i] - rest_[p]);
      const Quat own =
          halves_[i] < 0
              ? posture.turn[i]
              : Quat::Identity().slerp(0.5, posture.turn[static_cast<std::size_t>(halves_[i])]);
      placed.turn[i] = placed.turn[p] * own;
    }
  }
  return placed;
}

std::vector<Pose> Skeleton::poses(const Placement& placed) const {
  std::vector<Pose> poses(size());
  for (std::size_t i = 0; i < size(); ++i)
    poses[i] = {placed.position[i], placed.turn[i] * rest_rotation_[i]};
  return poses;
}

namespace {

// Heavy cotton, doubled at the hem and the cuffs; the belt is sewn of several layers.
constexpr std::array<Fabric, 3> fabrics = {
    Fabric{"Skirt", 0.06, 0.002, 0.10, 10, "UpLeg", 0.022},
    Fabric{"Cuff", 0.04, 0.002, 0.06, 0, "ForeArm", 0.010},
    Fabric{"Tail", 0.08, 0.002, 0.04, 0, "SkirtFront", 0.026}};

}  // namespace

std::string_view without_side(std::string_view bone) {
  for (const std::string_view side : {"Left", "Right"})
    if (bone.starts_with(side)) return bone.substr(side.size());
  return bone;
}

const Fabric* fabric_of(std::string_view bone) {
  const auto found = std::ranges::find_if(
      fabrics, [&](const Fabric& fabric) { return without_side(bone).starts_with(fabric.name); });
  return found == fabrics.end() ? nullptr : &*found;
}

}  // namespace taut::scenes
