// Reading files whole, with a limit.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "scenes/files/error.h"

namespace taut::scenes {

/// A message in the form of all asset errors: the file's name, then the cause.
BadAsset bad_asset(const std::filesystem::path& file, const std::string& cause);

/// The bytes of a regular file, which never keeps a reader waiting. `expected` is what it should
/// be, as in "a scene file". Throws BadAsset: missing, a directory, a pipe or a device, unreadable,
/// or larger than `limit` (bytes).
std::string read_regular_file(const std::filesystem::path& file, std::size_t limit,
                              std::string_view expected);

/// The same of anything up to 1 GiB.
std::string read_bytes(const std::filesystem::path& file);

}  // namespace taut::scenes
