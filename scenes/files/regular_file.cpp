#include "scenes/files/regular_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>

#include "scenes/files/standard_input.h"

namespace taut::scenes {
namespace {

/// The kind of a file that is not regular, in words.
const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

/// The bytes of an open file that messages call `name`.
std::string read_all(int file, const std::filesystem::path& name, std::size_t limit,
                     std::string_view expected) {
  const auto fail = [&](const std::string& cause) { throw bad_asset(name, cause); };
  std::string bytes;
  struct stat status {};
  if (fstat(file, &status) == 0 && static_cast<std::size_t>(status.st_size) <= limit) {
    bytes.reserve(static_cast<std::size_t>(status.st_size));
  }
  char block[1 << 16];
  ssize_t count = 0;
  while (bytes.size() <= limit && (count = read(file, block, sizeof block)) != 0) {
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(fmt::format("cannot be read: {}", std::strerror(errno)));
    bytes.append(block, static_cast<std::size_t>(count));
  }
  if (bytes.size() > limit) {
    fail(fmt::format("is larger than {} MiB, expected {}", limit >> 20, expected));
  }
  return bytes;
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
  return read_all(handle.number, file, limit, expected);
}

std::string read_standard_input(std::size_t limit, std::string_view expected) {
  return read_all(STDIN_FILENO, "standard input", limit, expected);
}

std::string read_bytes(const std::filesystem::path& file) {
  return read_regular_file(file, std::size_t{1} << 30, "a regular file");
}

}  // namespace taut::scenes
