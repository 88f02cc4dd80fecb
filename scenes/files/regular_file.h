// Reading files and standard input whole, with a limit.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "scenes/files/error.h"

namespace taut::scenes {

/// A message in the form of all asset errors: the file's name, then the cause, both printable().
BadAsset bad_asset(const std::filesystem::path& file, const std::string& cause);

/// The bytes of a regular file, which never keeps a reader waiting. `expected` is what it should
/// be, as in "a scene file". Throws BadAsset: missing, a directory, a pipe or a device, unreadable,
/// or larger than `limit` (bytes).
std::string read_regular_file(const std::filesystem::path& file, std::size_t limit,
                              std::string_view expected);

/// The bytes of a regular file at `name`, relative to the folder `root` (canonical). Links are
/// followed inside of `root` only, whoever changes them meanwhile: each folder on the way is opened
/// from the one before. Nothing where there is no such file. Throws BadAsset in the name of
/// `shown`: as read_regular_file(), and where the way leads out of `root`.
std::optional<std::string> read_beneath(const std::filesystem::path& root,
                                        const std::filesystem::path& name, std::size_t limit,
                                        std::string_view expected, const std::string& shown);

/// The same as read_regular_file() of anything up to 1 GiB.
std::string read_bytes(const std::filesystem::path& file);

// Scenes that are read from standard input.

/// The name that stands for standard input in the place of a scene file.
inline constexpr std::string_view kStandardInput = "-";

/// The bytes of standard input, up to its end; `expected` is what they should be. Throws BadAsset
/// where they cannot be read or are more than `limit`.
std::string read_standard_input(std::size_t limit, std::string_view expected);

/// The text of a scene file, or of standard input, which is read once and remembered. Throws
/// BadScene.
std::string read_scene_text(const std::filesystem::path& file);

}  // namespace taut::scenes
