// A child process that reads all its input, writes its output and ends.
#pragma once

#include <string>
#include <vector>

namespace taut {

struct ChildResult {
  int status = 0;  // exit code; 128 + number when a signal ended it
  std::string output;
  std::string errors;
};

/// Runs `arguments[0]`, found on the PATH and with no shell between, on `input`, and waits for its
/// end. Input and output live in memory files, so neither side can block the other. Throws
/// std::system_error where the program cannot be started.
ChildResult run_child(const std::vector<std::string>& arguments, const std::string& input);

}  // namespace taut
