// A program made of commands: options in, one command run, an exit code out.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "render/program/command.h"
#include "scenes/load/faults.h"

namespace taut::program {

using AddCommand = void (*)(CLI::App& app, Program& program);

/// The program's name, commands and options, as run_program() takes them.
void describe_program(CLI::App& app, Program& program, std::span<const AddCommand> commands);

/// Several things that are wrong with a scene.
class BadScenes : public scenes::BadScene {
 public:
  explicit BadScenes(scenes::Faults those)
      : scenes::BadScene(those.first.front()), faults(std::move(those)) {}
  scenes::Faults faults;
};

/// Does some work, and tells what it throws: in words on standard error and, with --json, as
/// {"error": ...} on standard output. Returns the exit code.
int guarded(const Common& common, const std::function<int()>& work);

/// Runs a command from within another: its name and what stands behind that. Returns the exit code,
/// or throws as the command does.
int run_words(const Common& common, AddCommand add, std::vector<std::string> words);

/// Returns the exit code.
int run_program(int argc, char** argv, std::span<const AddCommand> commands);

// Work that is done again whenever a file is saved.

/// Calls `work` now and whenever one of the `files` changes, which are asked for each time, until
/// the program is interrupted, which is how it ends well. Errors of `work` are told, and wait for
/// the next change.
int watch(const std::function<std::vector<std::filesystem::path>()>& files, const Common& common,
          const std::function<int()>& work);

}  // namespace taut::program
