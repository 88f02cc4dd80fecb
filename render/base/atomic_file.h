// Files that appear under their name only when they are complete.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "render/base/leftovers.h"

namespace taut::render {

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

}  // namespace taut::render
