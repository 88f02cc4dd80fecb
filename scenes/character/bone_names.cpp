#include "scenes/character/bone_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "scenes/files/regular_file.h"
#include "sim/motion/printable.h"

namespace taut::scenes {
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
