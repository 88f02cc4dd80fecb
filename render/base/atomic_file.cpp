#include "render/base/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <random>

#include "render/base/error.h"
#include "render/base/interrupt.h"

namespace taut::render {

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

bool try_to_lock(int file, const std::filesystem::path& name) {
  if (flock(file, LOCK_EX | LOCK_NB) == 0) return true;
  if (errno == EWOULDBLOCK) return false;
  throw CannotWrite(fmt::format("{}: cannot be locked: {}", name.string(), std::strerror(errno)));
}

void remove_output(const std::filesystem::path& name) {
  std::error_code error;
  std::filesystem::remove_all(name, error);
  if (error)
    throw CannotWrite(fmt::format("{}: cannot be removed: {}", name.string(), error.message()));
}

namespace {

bool same_file(int file, const std::filesystem::path& name) {
  struct stat opened {
  }, named{};
  return fstat(file, &opened) == 0 && stat(name.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

}  // namespace

bool is_standard_output(const std::filesystem::path& name) {
  return same_file(STDOUT_FILENO, name);
}

AtomicFile::AtomicFile(std::filesystem::path name, Unopened)
    : name_(std::move(name)), part_(name_) {
  part_ += ".part";
}

// The destructor also runs where this body throws.
AtomicFile::AtomicFile(std::filesystem::path name) : AtomicFile(std::move(name), Unopened()) {
  std::error_code error;
  if (std::filesystem::is_directory(name_, error)) {
    throw CannotWrite(fmt::format("{}: is a directory, expected a file to write", name_.string()));
  }
  if (std::filesystem::is_other(name_, error)) {
    in_place_ = true;
    // A pipe is opened when somebody reads it.
    while ((file_ = open(name_.c_str(), O_WRONLY | O_CLOEXEC)) < 0 && errno == EINTR) {
      stop_if_interrupted();
    }
    if (file_ < 0) fail("cannot be opened");
    return;
  }
  error.clear();  // there may be no such file yet
  if (name_.has_parent_path()) std::filesystem::create_directories(name_.parent_path(), error);
  if (error) {
    throw CannotWrite(fmt::format("{}: cannot be created: {}", name_.string(), error.message()));
  }
  file_ = open(part_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) fail("cannot be created");
  // Another writer may have renamed the .part between our open and our lock: then it is no longer
  // ours to empty.
  if (!try_to_lock(file_, name_) || !same_file(file_, part_)) {
    close(file_);
    file_ = -1;
    throw CannotWrite(fmt::format("{}: another run is writing it", name_.string()));
  }
  unfinished_.emplace(part_);
  if (ftruncate(file_, 0) != 0) fail("cannot be emptied");
}

AtomicFile::~AtomicFile() {
  if (file_ < 0) return;
  if (!in_place_) unlink(part_.c_str());
  close(file_);
}

void AtomicFile::write(std::string_view bytes) {
  if (!write_all(file_, bytes)) fail("cannot be written");
}

void AtomicFile::commit() {
  if (!in_place_) {
    struct stat replaced {
    }, own{};
    if (stat(name_.c_str(), &replaced) == 0 && fstat(file_, &own) == 0) {
      const mode_t mode = (replaced.st_mode & 07777) | S_IWUSR;
      if (mode != (own.st_mode & 07777) && fchmod(file_, mode) != 0)
        fail("cannot be given its permissions");
    }
    if (fsync(file_) != 0) fail("cannot be written");
    if (rename(part_.c_str(), name_.c_str()) != 0) fail("cannot be renamed");
    unfinished_.reset();  // before the lock goes: another run may make such a file then
  }
  close(file_);
  file_ = -1;
}

void AtomicFile::fail(const char* action) const {
  throw CannotWrite(fmt::format("{}: {}: {}", name_.string(), action, std::strerror(errno)));
}

void write_output(std::string_view bytes) {
  if (!write_all(STDOUT_FILENO, bytes)) {
    throw CannotWrite(fmt::format("standard output: {}", std::strerror(errno)));
  }
}

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDigits = 16;

bool is_part_of(const fs::path& file, const std::string& name) {
  const std::string text = file.filename().string();
  if (!text.starts_with(name + '.') || !text.ends_with(".part")) return false;
  const std::size_t begin = name.size() + 1, end = text.size() - std::strlen(".part");
  return end - begin == kDigits && text.find_first_not_of("0123456789abcdef", begin) == end;
}

/// Nobody locks what a run left that was killed.
void remove_unfinished(const fs::path& name) {
  const fs::path folder = name.has_parent_path() ? name.parent_path() : fs::path(".");
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!is_part_of(entry.path(), name.filename().string())) continue;
    const int file = open(entry.path().c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
    if (file < 0) continue;
    if (flock(file, LOCK_EX | LOCK_NB) == 0) unlink(entry.path().c_str());
    close(file);
  }
}

}  // namespace

PartFile::PartFile(fs::path name) : name_(std::move(name)) {
  remove_unfinished(name_);
  std::random_device chance;
  part_ = name_;
  part_ += fmt::format(".{:08x}{:08x}.part", std::uint32_t(chance()), std::uint32_t(chance()));
  lock_ = open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  // Another run may take the file for a leftover before it is locked: then the name is free, and
  // the program that is to write there makes it again.
  if (lock_ >= 0 && flock(lock_, LOCK_EX) == 0) {
    unfinished_.emplace(part_);
    return;
  }
  const int cause = errno;
  if (lock_ >= 0) {
    unlink(part_.c_str());
    close(lock_);
  }
  throw CannotWrite(fmt::format("{}: cannot be created: {}", name_.string(), std::strerror(cause)));
}

PartFile::~PartFile() {
  std::error_code ignored;
  if (!part_.empty()) fs::remove(part_, ignored);
  close(lock_);
}

int PartFile::why_full() const {
  const off_t size = lseek(lock_, 0, SEEK_END);
  const bool grows = size >= 0 && write_all(lock_, std::string_view("", 1)) &&
                     ftruncate(lock_, size) == 0 && fsync(lock_) == 0;
  return grows ? 0 : errno;
}

void PartFile::commit() {
  std::error_code error;
  fs::rename(part_, name_, error);
  if (error) throw CannotWrite(fmt::format("{}: {}", name_.string(), error.message()));
  unfinished_.reset();
  part_.clear();
}

}  // namespace taut::render
