// BVH files: motion capture without a body.
#pragma once

#include <filesystem>
#include <string>

#include "scenes/model/model.h"

namespace taut::scenes {

/// The skeleton, drawn as a rod from each joint to the next, with its motion as the one animation,
/// called "motion". Lengths are those of the file, whose unit nobody knows. Throws BadAsset.
Model read_bvh(const std::filesystem::path& file, const std::string& content);

}  // namespace taut::scenes
