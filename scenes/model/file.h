// Reading asset files whole, with a limit.
#pragma once

#include <filesystem>
#include <string>

#include "scenes/error.h"

namespace taut {

/// The largest asset file that is read, bytes.
constexpr std::size_t asset_limit = 64u << 20;

/// A message in the form of all asset errors: the file's name, then the cause.
BadAsset bad_asset(const std::filesystem::path& file, const std::string& cause);

/// The bytes of a regular file. Throws BadAsset: missing, a directory, unreadable, empty, or larger
/// than asset_limit.
std::string read_asset(const std::filesystem::path& file);

}  // namespace taut
