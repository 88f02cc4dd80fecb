// Wavefront OBJ files: proved sound before the importer reads them.
#pragma once

#include <filesystem>
#include <string>

namespace taut::scenes {

/// Accepts polygons, their groups and materials; refuses anything else, broken numbers, and faces
/// whose vertices do not exist. Throws BadAsset naming the line.
void check_obj(const std::filesystem::path& file, const std::string& content);

}  // namespace taut::scenes
