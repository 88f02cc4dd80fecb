// Scenes that are read from standard input.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace taut::scenes {

/// The name that stands for standard input in the place of a scene file.
inline constexpr std::string_view kStandardInput = "-";

/// The bytes of standard input, up to its end; `expected` is what they should be. Throws BadAsset
/// where they cannot be read or are more than `limit`.
std::string read_standard_input(std::size_t limit, std::string_view expected);

/// The text of a scene file, or of standard input, which is read once and remembered. Throws
/// BadScene.
std::string read_scene_text(const std::filesystem::path& file);

}  // namespace taut::scenes
