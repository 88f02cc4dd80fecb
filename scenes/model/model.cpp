#include "scenes/model/model.h"

#include <algorithm>

namespace taut::scenes {

int Model::bone(std::string_view bone_name) const {
  const auto found = std::find_if(bones.begin(), bones.end(),
                                  [&](const Bone& bone) { return bone.name == bone_name; });
  return found == bones.end() ? -1 : static_cast<int>(found - bones.begin());
}

}  // namespace taut::scenes
