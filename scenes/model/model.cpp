#include "scenes/model/model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "sim/motion/printable.h"

namespace taut::scenes {

int Model::bone(std::string_view bone_name) const {
  const auto found = std::find_if(bones.begin(), bones.end(),
                                  [&](const Bone& bone) { return bone.name == bone_name; });
  return found == bones.end() ? -1 : static_cast<int>(found - bones.begin());
}

void enlarge(Model& model, double scale) {
  const auto times = static_cast<float>(scale);
  for (Mesh& mesh : model.meshes)
    for (Vertex& vertex : mesh.vertices)
      for (float& x : vertex.position) x *= times;
  for (Bone& bone : model.bones) {
    bone.rest.position *= scale;
    bone.inverse_bind.topRightCorner<3, 1>() *= times;
  }
  for (Animation& animation : model.animations)
    for (BoneTrack& track : animation.tracks)
      if (track.of == BoneTrack::Of::position)
        for (float& x : track.values) x *= times;
}

void leave_out_animations(Model& model, const std::string& file) {
  if (model.animations.empty()) return;
  std::vector<std::string> names;
  for (const Animation& animation : model.animations)
    names.push_back(fmt::format("\"{}\"", animation.name));
  constexpr std::size_t kShown = 5;
  const bool some = names.size() > kShown;
  if (some) names.resize(kShown);
  model.left_out.push_back(printable(fmt::format("{}: left out: animations ({}{})", file,
                                                 fmt::join(names, ", "), some ? ", ..." : "")));
  model.animations.clear();
}

void make_rigid(Model& model, const std::string& file) {
  leave_out_animations(model, file);
  model.bones.clear();
  for (Mesh& mesh : model.meshes)
    for (Vertex& vertex : mesh.vertices) {
      vertex.bones = {};
      vertex.weights = {};
    }
}

}  // namespace taut::scenes
