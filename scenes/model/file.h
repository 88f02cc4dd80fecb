// Reading asset files whole, with a limit.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "scenes/error.h"

namespace taut {

/// The largest asset file that is read, bytes.
constexpr std::size_t asset_limit = 64u << 20;

/// A message in the form of all asset errors: the file's name, then the cause.
BadAsset bad_asset(const std::filesystem::path& file, const std::string& cause);

/// Opens a file to be read. Throws BadAsset.
std::ifstream open_asset(const std::filesystem::path& file);

/// The bytes of any file. Throws BadAsset.
std::string read_bytes(const std::filesystem::path& file);

/// The bytes of a regular file. Throws BadAsset: missing, a directory, unreadable, empty, or larger
/// than asset_limit.
std::string read_asset(const std::filesystem::path& file);

}  // namespace taut
