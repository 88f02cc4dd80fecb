// Stopping on Ctrl-C and SIGTERM: the handlers leave a note, which long work looks at between two
// pieces, so that destructors run. Where the work does not look in time, the process ends without
// them, and leaves nothing half-written either.
#pragma once

#include <sys/types.h>

#include <exception>
#include <filesystem>

namespace taut::render {

/// Thrown by stop_if_interrupted; what() names the signal.
class Interrupted : public std::exception {
 public:
  explicit Interrupted(int number) : signal(number) {}
  const char* what() const noexcept override;
  int signal;  // SIGINT or SIGTERM
};

/// Notes SIGINT and SIGTERM from now on. The process ends 0.7 s after the first of them, or at a
/// second one that comes a tenth of a second or more after it, with the code 128 + its number and
/// without what remove_leftovers() removes. SIGPIPE and SIGXFSZ are ignored, so that writing
/// reports EPIPE and EFBIG instead.
void catch_interrupts();

/// The signal that came, or 0.
int pending_interrupt();

/// Throws Interrupted if a signal came. Cheap: one atomic read.
void stop_if_interrupted();

// What must not outlive the process, where it ends without destructors: unfinished files and
// children. The table of them needs neither memory nor locks, so that a signal handler may read it.

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
