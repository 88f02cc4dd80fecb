// The names of a figure's bones, and models that call them otherwise.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/model/model.h"

namespace taut::scenes {

/// The bones that a figure needs; it moves others, as fingers, where a model has them.
const std::vector<std::string_view>& needed_bones();

/// All names that mean something: the needed ones, fingers, toes, and those of the face.
const std::vector<std::string_view>& known_bones();

/// Pairs of a name that a figure knows and the one that the model has for it.
using BoneNames = std::vector<std::pair<std::string, std::string>>;

/// Those of a character of Mixamo: without the prefix ("mixamorig:", "mixamorig2:"), and Spine2 is
/// the Chest.
BoneNames mixamo_names(const Model& model);

/// Gives the model's bones the figure's names. Throws BadAsset with all that the model lacks; a
/// bone that is called so and not meant gets another name.
void rename_bones(Model& model, const BoneNames& names);

/// Throws BadAsset with all needed bones that the model lacks, and what might be done about it.
void check_bones(const Model& model);

}  // namespace taut::scenes
