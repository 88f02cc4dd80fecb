// Reading files whole, with a limit.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "scenes/error.h"

namespace taut {

/// A message in the form of all asset errors: the file's name, then the cause.
BadAsset bad_asset(const std::filesystem::path& file, const std::string& cause);

/// The bytes of a regular file, which never keeps a reader waiting. `expected` is what it should
/// be, as in "a scene file". Throws BadAsset: missing, a directory, a pipe or a device, unreadable,
/// or larger than `limit` (bytes).
std::string read_regular_file(const std::filesystem::path& file, std::size_t limit,
                              std::string_view expected);

/// Opens any file to be read. Throws BadAsset.
std::ifstream open_asset(const std::filesystem::path& file);

/// The bytes of any file. Throws BadAsset.
std::string read_bytes(const std::filesystem::path& file);

}  // namespace taut
