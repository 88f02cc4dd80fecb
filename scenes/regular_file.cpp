#include "scenes/regular_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <new>

namespace taut {
namespace {

/// What a file is that is not regular, in words.
const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

/// An open file, closed at its end.
struct Handle {
  int number;
  ~Handle() {
    if (number >= 0) close(number);
  }
};

}  // namespace

BadAsset bad_asset(const std::filesystem::path& file, const std::string& cause) {
  return BadAsset(fmt::format("{}: {}", file.string(), cause));
}

std::string read_regular_file(const std::filesystem::path& file, std::size_t limit,
                              std::string_view expected) {
  const auto fail = [&](const std::string& cause) { throw bad_asset(file, cause); };
  // A pipe would make a blocking open wait for its writer.
  const Handle handle{open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)};
  if (handle.number < 0 && errno == ENOMEM) throw std::bad_alloc();
  if (handle.number < 0) fail(fmt::format("cannot be opened: {}", std::strerror(errno)));
  struct stat status {};
  if (fstat(handle.number, &status) != 0) {
    fail(fmt::format("cannot be read: {}", std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode)) {
    fail(fmt::format("is {}, expected {}", kind_of(status.st_mode), expected));
  }
  std::string bytes;
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size <= limit) bytes.reserve(size);
  char block[1 << 16];
  ssize_t count = 0;
  while (bytes.size() <= limit && (count = read(handle.number, block, sizeof block)) != 0) {
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(fmt::format("cannot be read: {}", std::strerror(errno)));
    bytes.append(block, static_cast<std::size_t>(count));
  }
  if (bytes.size() > limit) {
    fail(fmt::format("is larger than {} MiB, expected {}", limit >> 20, expected));
  }
  return bytes;
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

}  // namespace taut
