// The files that a scene is made of.
#pragma once

#include <filesystem>
#include <vector>

namespace taut::scenes {

/// The scene's file, the one that it extends, and those that it names and that are there: models,
/// paths, winds. Of a file that cannot be read, that alone.
std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene);

}  // namespace taut::scenes
