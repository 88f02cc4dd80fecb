#include "scenes/character/skeleton.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string>

#include "scenes/files/files.h"
#include "sim/motion/printable.h"

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

namespace {

/// The rotation that takes x to `along` and z to `normal` (perpendicular to it).
Mat3 frame(const Vec3& along, const Vec3& normal) {
  Mat3 m;
  m.col(0) = along.normalized();
  m.col(2) = (normal - normal.dot(m.col(0)) * m.col(0)).normalized();
  m.col(1) = m.col(2).cross(m.col(0));
  return m;
}

}  // namespace

LimbTurns bend_limb(const Limb& limb, const Vec3& root, const Vec3& target, const Vec3& pole) {
  const double a = limb.upper.norm(), b = limb.lower.norm();
  const Vec3 to_target = target - root;
  const Vec3 along = to_target.norm() > 1e-9 ? to_target.normalized() : Vec3(0, -1, 0);
  const double distance = std::clamp(to_target.norm(), 1.05 * std::abs(a - b), limb.reach());
  const Vec3 across = pole - pole.dot(along) * along;
  const Vec3 side = across.norm() > 1e-9 ? across.normalized() : along.unitOrthogonal();

  const double x = (a * a - b * b + distance * distance) / (2 * distance);
  const double h = std::sqrt(std::max(a * a - x * x, 0.0));
  const Vec3 middle = root + x * along + h * side;
  const Vec3 normal = along.cross(side) * -1;  // as of cross(upper, lower) of the bent limb
  Vec3 rest_normal = limb.upper.cross(limb.lower);
  constexpr double kStraight = 0.05;  // rad
  if (rest_normal.norm() < kStraight * a * b && !limb.bends.isZero())
    rest_normal = limb.upper.cross(limb.bends);
  if (rest_normal.norm() < 1e-9 * a * b) rest_normal = limb.upper.unitOrthogonal();
  const auto turn = [&](const Vec3& rest, const Vec3& now) {
    return Quat(frame(now, normal) * frame(rest, rest_normal).transpose());
  };
  return {turn(limb.upper, middle - root), turn(limb.lower, root + distance * along - middle),
          middle};
}

double twist_about(const Quat& rotation, const Vec3& axis) {
  const double angle = 2 * std::atan2(rotation.vec().dot(axis), rotation.w());
  return std::remainder(angle, 2 * M_PI);
}

namespace {

constexpr std::size_t kShown = 8;  // names of a model in a message

std::vector<std::string_view> both_sides(std::initializer_list<std::string_view> parts) {
  static std::vector<std::string> kept = [] {
    std::vector<std::string> names;
    names.reserve(256);  // views of them stay valid
    return names;
  }();
  std::vector<std::string_view> names;
  for (const char* side : {"Left", "Right"})
    for (const std::string_view part : parts)
      names.push_back(kept.emplace_back(fmt::format("{}{}", side, part)));
  return names;
}

std::vector<std::string_view> joined(std::vector<std::string_view> names,
                                     const std::vector<std::string_view>& more) {
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

/// A name of Mixamo without its prefix.
std::string_view without_prefix(std::string_view name) {
  constexpr std::string_view prefix = "mixamorig";
  if (!name.starts_with(prefix)) return name;
  name.remove_prefix(prefix.size());
  while (!name.empty() && std::isdigit(static_cast<unsigned char>(name.front())))
    name.remove_prefix(1);
  if (name.starts_with(':') || name.starts_with('_')) name.remove_prefix(1);
  return name;
}

std::vector<std::string_view> lacking(const Model& model) {
  std::vector<std::string_view> names;
  for (const std::string_view name : needed_bones())
    if (model.bone(name) < 0) names.push_back(name);
  return names;
}

}  // namespace

const std::vector<std::string_view>& needed_bones() {
  static const std::vector<std::string_view> names = joined(
      {"Hips", "Spine", "Head"}, both_sides({"Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot"}));
  return names;
}

const std::vector<std::string_view>& known_bones() {
  static const std::vector<std::string_view> names = [] {
    auto all = joined(needed_bones(), {"Spine1", "Chest", "Neck", "Jaw"});
    return joined(
        all, both_sides({"Shoulder",    "Elbow",      "ToeBase",    "Eye",         "Lid",
                         "Brow",        "Mouth",      "HandThumb1", "HandThumb2",  "HandThumb3",
                         "HandIndex1",  "HandIndex2", "HandIndex3", "HandMiddle1", "HandMiddle2",
                         "HandMiddle3", "HandRing1",  "HandRing2",  "HandRing3",   "HandPinky1",
                         "HandPinky2",  "HandPinky3"}));
  }();
  return names;
}

BoneNames mixamo_names(const Model& model) {
  BoneNames names;
  for (const Bone& bone : model.bones) {
    std::string_view ours = without_prefix(bone.name);
    if (ours == "Spine2") ours = "Chest";
    if (ours != bone.name && std::ranges::find(known_bones(), ours) != known_bones().end())
      names.emplace_back(ours, bone.name);
  }
  return names;
}

void rename_bones(Model& model, const BoneNames& names) {
  std::vector<int> of_name;
  std::vector<std::string> missing;
  for (const auto& [ours, theirs] : names) {
    of_name.push_back(model.bone(theirs));
    if (of_name.back() < 0) missing.push_back(fmt::format("\"{}\"", theirs));
  }
  if (!missing.empty()) {
    throw bad_asset(model.name,
                    printable(fmt::format("has no bone{} {}", missing.size() > 1 ? "s" : "",
                                          fmt::join(missing, ", "))));
  }
  for (const auto& [ours, theirs] : names) {
    const int taken = model.bone(ours);
    if (taken >= 0) model.bones[static_cast<std::size_t>(taken)].name += " of the file";
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    model.bones[static_cast<std::size_t>(of_name[i])].name = names[i].first;
}

void check_bones(const Model& model) {
  const std::vector<std::string_view> missing = lacking(model);
  if (missing.empty()) return;
  std::string text =
      fmt::format("has no bone{} {}", missing.size() > 1 ? "s" : "", fmt::join(missing, ", "));
  Model renamed;  // names are all that counts
  for (const Bone& bone : model.bones) renamed.bones.emplace_back().name = bone.name;
  rename_bones(renamed, mixamo_names(renamed));
  if (lacking(renamed).empty()) {
    text += "; bones = \"mixamo\" finds them";
  } else if (!model.bones.empty()) {
    std::vector<std::string_view> theirs;
    for (std::size_t i = 0; i < std::min(kShown, model.bones.size()); ++i)
      theirs.push_back(model.bones[i].name);
    text += fmt::format("; a table bones = {{ {} = \"...\" }} says which they are; it has: {}{}",
                        missing.front(), fmt::join(theirs, ", "),
                        model.bones.size() > kShown
                            ? fmt::format(" and {} more", model.bones.size() - kShown)
                            : "");
  }
  throw bad_asset(model.name, printable(text));
}

}  // namespace taut::scenes
