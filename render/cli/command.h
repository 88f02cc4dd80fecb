// What the commands share: registration, common options, and the way to say that they are misused.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <stdexcept>
#include <string>

#include "render/cli/exit_code.h"

namespace taut::cli {

/// Options that every command takes.
struct Common {
  bool quiet = false;  // no progress and no notes on standard error; errors remain
  bool json = false;   // the result on standard output as JSON
  int threads = 0;     // 0: as many as the machine has
};

/// Options that parse but make no sense together or for this scene: exit code 2.
class Misuse : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Filled while options are parsed; run() does the chosen command's work and returns an exit code.
struct Program {
  Common common;
  std::function<int()> run;
};

/// Adds a command with the common options. `examples` ends its --help.
CLI::App& add_command(CLI::App& app, Program& program, const std::string& name,
                      const std::string& summary, const std::string& examples);

}  // namespace taut::cli
