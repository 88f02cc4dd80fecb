// Files that appear under their name only when they are complete.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "render/base/interrupt.h"

namespace taut::render {

// An open file that is closed when its owner goes.

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }

  bool is_open() const { return number_ >= 0; }
  int get() const { return number_; }
  void close() {
    if (is_open()) ::close(std::exchange(number_, -1));
  }

 private:
  int number_ = -1;
};

/// True where `name` is what standard output goes to, as /dev/stdout is.
bool is_standard_output(const std::filesystem::path& name);

/// Writes NAME.part; commit() makes it NAME, with the permissions of the file that it replaces, but
/// writable to its owner. Without a commit the destructor removes it. A process that is killed
/// leaves only the .part behind, which the next run overwrites. A pipe or a device of that name is
/// written as it is.
class AtomicFile {
 public:
  /// Makes missing folders. Throws CannotWrite, also when another process is writing the file.
  explicit AtomicFile(std::filesystem::path name);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Throws CannotWrite.
  void write(std::string_view bytes);

  /// Puts the bytes on the disk and then the file under its name. Throws CannotWrite.
  void commit();

 private:
  struct Unopened {};
  AtomicFile(std::filesystem::path name, Unopened);
  [[noreturn]] void fail(const char* action) const;

  std::filesystem::path name_, part_;
  int file_ = -1;
  bool in_place_ = false;
  std::optional<UnfinishedFile> unfinished_;
};

/// Writes `bytes` to standard output, all of them. Throws CannotWrite.
void write_output(std::string_view bytes);

/// Writes all of `bytes` to an open file; false, and errno, where it cannot.
bool write_all(int file, std::string_view bytes);

/// Locks an open file against other processes, until it is closed; false where another has it
/// locked. Throws CannotWrite, with `name` in the message.
bool try_to_lock(int file, const std::filesystem::path& name);

/// Removes a file or folder that may be there. Throws CannotWrite.
void remove_output(const std::filesystem::path& name);

// Files that another program writes for this run alone.

/// An empty file beside NAME, called NAME.XXXX.part by chance: whatever writes there after its run
/// was killed writes to no file of another run. commit() makes it NAME; without a commit the
/// destructor removes it.
class PartFile {
 public:
  /// Removes what killed runs left beside NAME. Throws CannotWrite.
  explicit PartFile(std::filesystem::path name);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  const std::filesystem::path& path() const { return part_; }

  /// The error number for what the file lacks (ENOSPC, EDQUOT, EFBIG, EIO), or 0. A file that was
  /// cut short by a full disk or a limit cannot take one more byte: that is tried, and undone.
  /// Bytes that are there go to the disk.
  int why_full() const;

  /// Throws CannotWrite.
  void commit();

 private:
  std::filesystem::path name_, part_;
  std::optional<UnfinishedFile> unfinished_;
  int lock_ = -1;  // open while the run lives: by it others know the file for no leftover
};

}  // namespace taut::render
