#include "scenes/model/file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <new>

namespace taut {

BadAsset bad_asset(const std::filesystem::path& file, const std::string& cause) {
  return BadAsset(fmt::format("{}: {}", file.string(), cause));
}

std::ifstream open_asset(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (in) return in;
  if (errno == ENOMEM) throw std::bad_alloc();
  throw bad_asset(file, fmt::format("cannot be opened: {}", std::strerror(errno)));
}

std::string read_bytes(const std::filesystem::path& file) {
  std::ifstream in = open_asset(file);
  try {
    return {std::istreambuf_iterator<char>(in), {}};
  } catch (const std::ios_base::failure& error) {
    throw bad_asset(file, fmt::format("cannot be read: {}", error.code().message()));
  }
}

std::string read_asset(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw bad_asset(file, "no such file");
  if (std::filesystem::is_directory(status)) throw bad_asset(file, "a directory, not a file");
  if (!std::filesystem::is_regular_file(status)) throw bad_asset(file, "not a regular file");

  std::ifstream in = open_asset(file);
  // One byte more than allowed tells a file that is too large, even one that grows meanwhile.
  std::string bytes(
      std::min<std::uintmax_t>(std::filesystem::file_size(file, error), asset_limit) + 1, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (in.bad()) throw bad_asset(file, "cannot be read");
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  if (bytes.size() > asset_limit)
    throw bad_asset(file, fmt::format("larger than {} MiB", asset_limit >> 20));
  if (bytes.empty()) throw bad_asset(file, "empty file");
  return bytes;
}

}  // namespace taut
