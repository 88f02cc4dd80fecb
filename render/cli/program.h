// A program made of commands: options in, one command run, an exit code out.
#pragma once

#include <span>

#include "render/cli/command.h"

namespace taut::cli {

using AddCommand = void (*)(CLI::App& app, Program& program);

/// The program's name, commands and options, as run_program() takes them.
void describe_program(CLI::App& app, Program& program, std::span<const AddCommand> commands);

/// Returns the exit code.
int run_program(int argc, char** argv, std::span<const AddCommand> commands);

}  // namespace taut::cli
