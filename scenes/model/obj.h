// Wavefront OBJ files: proved sound before the importer reads them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenes/model/imported.h"
#include "scenes/model/named_files.h"

namespace taut::scenes {

/// An OBJ file with polygons, their groups and materials alone, every number and index of them
/// proved to be sound.
struct CheckedObj {
  std::string text;
  std::string materials;              // of all its libraries
  Textures textures;                  // by the names of materials
  std::vector<std::string> left_out;  // a sentence each
};

/// `content` of an OBJ file, checked. Its libraries of materials come from `files`; nothing where
/// that wants some. What OBJ files may hold besides, lines or curves, is left out. Refuses unknown
/// statements, broken numbers, and faces whose vertices do not exist: throws BadAsset naming the
/// line.
std::optional<CheckedObj> checked_obj(const std::filesystem::path& file, const std::string& content,
                                      NamedFiles& files);

}  // namespace taut::scenes
