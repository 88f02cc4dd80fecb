// The page of memory that a program under faults shares with the test that makes them.
#pragma once

#include <atomic>
#include <cerrno>
#include <cstdint>

namespace taut::faults {

/// Kinds of calls that can fail.
enum Kind : int {
  kOpen,  // for writing
  kWrite,
  kSay,  // on standard output or standard error
  kSync,
  kRename,
  kUnlink,
  kMkdir,
  kMode,  // of a file
  kLock,
  kCut,
  kMemory,
  kSpawn,
  kPipe,  // and files in memory
  kThread,
  kKinds
};

/// The system's error for each.
constexpr int kErrors[kKinds] = {ENOSPC, ENOSPC, ENOSPC, EIO,    EIO,    EIO,    ENOSPC,
                                 EPERM,  ENOLCK, EIO,    ENOMEM, EAGAIN, EMFILE, EAGAIN};

enum class How : int { count, fail, fail_from_there_on, kill };

/// The test writes the first part before the program starts, and reads the rest after its end.
struct Page {
  Kind kind = kOpen;
  How how = How::count;
  std::uint64_t at = 0;        // which call fails, from 1
  bool in_children = false;    // calls of child processes count instead of the program's own
  std::atomic<int> owner = 0;  // process id of the program
  std::atomic<std::uint64_t> calls[kKinds] = {};
  char place[256] = {};  // what the call was about, as "rename a.part"
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// The environment variable that names the file of the page.
constexpr const char* kPageVariable = "TAUT_FAULT_PAGE";

}  // namespace taut::faults
