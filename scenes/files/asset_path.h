// Where the files that a scene names are looked for.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace taut::scenes {

/// A folder in which files are looked for, and why.
struct AssetFolder {
  std::string what;              // "--assets", "TAUT_ASSETS", "beside the scene", ...
  std::filesystem::path folder;  // canonical
  std::filesystem::path within;  // what is found must be inside of this
};

/// A folder that is looked into before all others, for the rest of the program: `--assets`.
void set_asset_folder(const std::filesystem::path& folder);

/// The folders for a scene in `folder`, in order: `--assets`, those of the environment's
/// TAUT_ASSETS (separated by colons), the scene's own, its project's (the nearest folder above it
/// with a CMakePresets.json or .git; else the folder of the scene, or above its golden suite), the
/// one that is installed beside the program, and the project in which the program was built.
std::vector<AssetFolder> asset_folders(const std::filesystem::path& folder);

/// The first file of that relative path in the asset folders of the current folder. Throws BadScene
/// if none has it.
std::filesystem::path shipped_file(const std::filesystem::path& path);

/// Throws std::bad_alloc where that is why a call of the library failed: those that take a code
/// say so by it.
void throw_if_out_of_memory(const std::error_code& error);

/// share/taut of the prefix that the running program is installed in; empty: it is in none.
std::filesystem::path installed_share();

/// The places as messages list them: `--assets (/a), beside the scene (/b)`.
std::string places(const std::vector<AssetFolder>& folders);

}  // namespace taut::scenes
