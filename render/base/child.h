// Child processes: a program that reads all its input, writes its output and ends; and a copy of
// this process whose work is killed at its limits.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace taut::render {

struct ChildResult {
  int status = 0;       // exit code; 128 + number when a signal ended it
  double cpu_time = 0;  // s, with the children that it waited for
  std::string output;
  std::string errors;
};

/// A child that uses no CPU time for so long counts as blocked.
constexpr std::chrono::milliseconds kPatience = std::chrono::minutes(1);

/// What a child may use; beyond it the kernel or run_child() ends it.
struct ChildLimits {
  std::chrono::milliseconds patience = kPatience;  // to do nothing
  std::size_t cpu_time = 0;                        // s; zero: any
  std::size_t output = 0;                          // bytes of a file that it writes; zero: any
};

/// Runs the program `arguments[0]`, found on the PATH, without a shell, in `folder` (empty: the
/// current one), on `input`, and waits for its end. Input and output are memory files, so that
/// neither side can block the other. A child that uses no CPU time for the limits' patience is
/// killed, and its errors say so; the kernel kills one whose parent dies, and one beyond the limits
/// of CPU time (SIGXCPU) or output (SIGXFSZ). Throws std::system_error if the program cannot be
/// started, and Interrupted once the child is killed.
ChildResult run_child(const std::vector<std::string>& arguments, const std::string& input,
                      const ChildLimits& limits = {}, const std::filesystem::path& folder = {});

// Work within limits: in a copy of this process that is killed at a limit.

struct Bounds {
  double cpu_time = 0;     // s, more than 0
  std::size_t memory = 0;  // bytes, beyond what the process has at the fork
};

/// Sends a text to the waiting process.
using Say = std::function<void(std::string_view text)>;

struct Bounded {
  enum class End { done, no_time, no_memory, failed };
  End end = End::failed;
  std::string said;  // until the end
};

/// Runs `work` in a copy of this process (fork) and collects what it says until it returns or
/// reaches a limit. An exception that leaves `work` ends it as `failed`, std::bad_alloc as
/// `no_memory`; the cause must be said by `work`. The copy has the caller's thread only, and dies
/// with the waiting thread. Throws std::system_error if the fork fails, and Interrupted once the
/// copy is killed.
Bounded run_bounded(const Bounds& bounds, const std::function<void(const Say& say)>& work);

/// CPU time (s) of this process, all its threads together; of a copy since the fork.
double process_seconds();
/// CPU time (s) of all processes that this one started and that have ended.
double children_seconds();

}  // namespace taut::render
