// The files that a scene names: the folders in which they are looked for, and reading them and
// standard input whole, with a limit.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "scenes/files/error.h"

namespace taut::scenes {

/// A message in the form of all asset errors: the file's name, then the cause, both printable().
BadAsset bad_asset(const std::filesystem::path& file, const std::string& cause);

/// The bytes of a regular file. `expected` says in messages what it should be: "a scene file".
/// Throws BadAsset if the file is missing, a directory, a pipe or a device (on which a read could
/// wait), unreadable, or larger than `limit` (bytes).
std::string read_regular_file(const std::filesystem::path& file, std::size_t limit,
                              std::string_view expected);

/// The bytes of a regular file at `name`, relative to the folder `root` (canonical). Links are
/// followed inside of `root` only, even if another process changes them meanwhile: each folder on
/// the way is opened from the one before. None if there is no such file. Throws BadAsset, which
/// names `shown`, as read_regular_file() does and if the way leads out of `root`.
std::optional<std::string> read_beneath(const std::filesystem::path& root,
                                        const std::filesystem::path& name, std::size_t limit,
                                        std::string_view expected, const std::string& shown);

/// read_regular_file() with a limit of 1 GiB.
std::string read_bytes(const std::filesystem::path& file);

/// The scene file of this name is standard input.
inline constexpr std::string_view kStandardInput = "-";

/// The bytes of standard input, up to its end; `expected` says in messages what they should be.
/// Throws BadAsset if they cannot be read or are more than `limit`.
std::string read_standard_input(std::size_t limit, std::string_view expected);

/// The text of a scene file, or of standard input, which is read once and remembered. Throws
/// BadScene.
std::string read_scene_text(const std::filesystem::path& file);

/// A folder in which files are looked for, and the reason, for messages.
struct AssetFolder {
  std::string what;              // "--assets", "TAUT_ASSETS", "beside the scene", ...
  std::filesystem::path folder;  // canonical
  std::filesystem::path within;  // files must lie in this folder, links resolved
};

/// Sets the folder of `--assets`, which is searched before all others until the program ends.
void set_asset_folder(const std::filesystem::path& folder);

/// The folders for a scene in `folder`, in order: `--assets`, those of the environment's
/// TAUT_ASSETS (separated by colons), the scene's own, its project's (the nearest folder above it
/// with a CMakePresets.json or .git; else the folder of the scene, or above its golden suite),
/// share/taut of the installed program, and the project in which the program was built.
std::vector<AssetFolder> asset_folders(const std::filesystem::path& folder);

/// The first file of that relative path in the asset folders of the current folder. Throws BadScene
/// if there is none.
std::filesystem::path shipped_file(const std::filesystem::path& path);

/// Throws std::bad_alloc if a call of std::filesystem failed for want of memory, which overloads
/// with an error code report by it.
void throw_if_out_of_memory(const std::error_code& error);

/// share/taut of the prefix that the running program is installed in; empty if it is not installed.
std::filesystem::path installed_share();

/// The folders as messages list them: `--assets (/a), beside the scene (/b)`.
std::string places(const std::vector<AssetFolder>& folders);

}  // namespace taut::scenes
