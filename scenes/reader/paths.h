// Paths of a scene, and numbers over time.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/format/document.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

/// The paths of a scene, in the order of the file.
std::vector<std::shared_ptr<const Path>> read_paths(const Document& document);

/// A path from rows t,x,y,z[,qw,qx,qy,qz] of a CSV file. Throws BadAsset with file:line.
Path read_path_csv(const std::filesystem::path& file);
/// The same from the file's text.
Path path_from_csv(const std::string& text, const std::filesystem::path& file);

/// A number over time, from the values of keys: the x of a path (Hold::turn, Winch::paths).
std::shared_ptr<const Path> read_number_keys(const Document& document, const Value& list,
                                             std::string_view value);

}  // namespace taut::scenes
