#include "render/base/part_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <random>

#include "render/base/atomic_file.h"
#include "render/base/error.h"

namespace taut::render {
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
void remove_leftovers(const fs::path& name) {
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
  remove_leftovers(name_);
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
