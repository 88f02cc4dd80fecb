// A child process that reads all its input, writes its output and ends.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace taut::render {

struct ChildResult {
  int status = 0;       // exit code; 128 + number when a signal ended it
  double cpu_time = 0;  // s, with the children that it waited for
  std::string output;
  std::string errors;
};

/// A child that sits and does nothing for so long is taken to be blocked.
constexpr std::chrono::milliseconds kPatience = std::chrono::minutes(1);

/// What a child may use; beyond it the kernel or run_child() ends it.
struct ChildLimits {
  std::chrono::milliseconds patience = kPatience;  // to do nothing
  std::size_t cpu_time = 0;                        // s; zero: any
  std::size_t output = 0;                          // bytes of a file that it writes; zero: any
};

/// Runs `arguments[0]`, found on the PATH and with no shell between, on `input` in `folder` (empty:
/// the present one), and waits for its end. Input and output live in memory files, so neither side
/// can block the other. A child that wants no CPU time for the limits' patience is killed, and its
/// errors say so; one whose parent dies is killed by the kernel, and so is one beyond the limits of
/// CPU time (SIGXCPU) and of output (SIGXFSZ). Throws std::system_error where the program cannot be
/// started, and Interrupted, the child killed.
ChildResult run_child(const std::vector<std::string>& arguments, const std::string& input,
                      const ChildLimits& limits = {}, const std::filesystem::path& folder = {});

}  // namespace taut::render
