// A child process that reads all its input, writes its output and ends.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace taut::render {

struct ChildResult {
  int status = 0;  // exit code; 128 + number when a signal ended it
  std::string output;
  std::string errors;
};

/// A child that sits and does nothing for so long is taken to be blocked.
constexpr std::chrono::milliseconds kPatience = std::chrono::minutes(1);

/// Runs `arguments[0]`, found on the PATH and with no shell between, on `input` in `folder` (empty:
/// the present one), and waits for its end. Input and output live in memory files, so neither side
/// can block the other. A child that wants no CPU time for `patience` is killed, and its errors say
/// so; one whose parent dies is killed by the kernel. Throws std::system_error where the program
/// cannot be started, and Interrupted, the child killed.
ChildResult run_child(const std::vector<std::string>& arguments, const std::string& input,
                      std::chrono::milliseconds patience = kPatience,
                      const std::filesystem::path& folder = {});

}  // namespace taut::render
