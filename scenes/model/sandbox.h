// Work on untrusted input in a child process that can harm nothing.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace taut::scenes {

struct SandboxLimits {
  std::size_t memory = 0;  // bytes, beyond what the process has at the fork
  std::size_t reply = 0;   // bytes
  double cpu_time = 0;     // s, more than 0
  double wall_time = 0;    // s, for a child that waits instead of working
};

struct SandboxResult {
  /// no_memory: it takes more than the limit given here; out_of_memory: more than this process may
  /// take, or than the machine has left; too_long: its reply.
  enum class End { replied, no_memory, out_of_memory, too_long, no_time, forbidden, crashed };
  End end = End::crashed;
  int status = 0;  // exit code; 128 + number where a signal ended it
  std::string reply;
};

/// Runs `work` in a copy of this process and waits for what it returns. The copy has no file of
/// the process but standard error and can open none, takes no more than the limits, and is killed
/// by any call of the system but those of allow_few_calls(), where the kernel has such filters. Of
/// threads, only the caller's is in it: `work` must not wait for a lock that another may hold;
/// those of memory are free there (glibc frees them at a fork). It dies with the thread that waits
/// for it. Exceptions of `work` end as crashes. Throws std::system_error where there can be no
/// child.
SandboxResult run_in_sandbox(const SandboxLimits& limits, const std::function<std::string()>& work);

}  // namespace taut::scenes
