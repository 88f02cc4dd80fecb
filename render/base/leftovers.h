// What must not outlive the process, where it ends without destructors: unfinished files and
// children. The table of them needs neither memory nor locks, so that a signal handler may read it.
#pragma once

#include <sys/types.h>

#include <filesystem>

namespace taut::render {

/// A file that remove_leftovers() removes, for as long as the object lives. Beyond 256 at a time,
/// and with names longer than PATH_MAX, a file stays.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::filesystem::path& file);
  ~UnfinishedFile() { finish(); }
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  /// From now on the file stays.
  void finish() noexcept;

 private:
  int slot_ = -1;
};

/// A child process that remove_leftovers() kills, for as long as the object lives. Beyond 64 at a
/// time, a child stays.
class RunningChild {
 public:
  explicit RunningChild(pid_t child);
  ~RunningChild() { finish(); }
  RunningChild(const RunningChild&) = delete;
  RunningChild& operator=(const RunningChild&) = delete;

  /// Before the child is waited for: its number may be another's after that.
  void finish() noexcept;

 private:
  int slot_ = -1;
};

/// Kills the children, then removes the files. Safe in a signal handler.
void remove_leftovers() noexcept;

}  // namespace taut::render
