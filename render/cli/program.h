// A program made of commands: options in, one command run, an exit code out.
#pragma once

#include <initializer_list>

#include "render/cli/command.h"

namespace taut::cli {

using AddCommand = void (*)(CLI::App& app, Program& program);

/// Returns the exit code.
int run_program(int argc, char** argv, std::initializer_list<AddCommand> commands);

}  // namespace taut::cli
