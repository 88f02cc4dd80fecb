// Writes taut's manual pages and its completion for shells from its own list of commands and
// options.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace taut::package {

// A program's commands and options as its option parser knows them, for manuals and completion.

struct DescribedOption {
  std::string shorts, longs;         // "q", "quiet"; both empty: a positional
  std::string value;                 // "TEXT"; a positional's name; empty: a flag
  std::vector<std::string> choices;  // empty: anything
  std::string text;
  bool required = false;

  bool is_positional() const { return shorts.empty() && longs.empty(); }
};

struct DescribedCommand {
  std::string path;  // "taut golden check"
  std::string summary, footer;
  std::vector<DescribedOption> options;
  std::vector<std::string> commands;  // names of those below it
};

/// The program first, each command before those below it.
std::vector<DescribedCommand> described(const CLI::App& app);

/// taut.1, taut-render.1, ... by name.
std::string manual_page(const DescribedCommand& command,
                        const std::vector<DescribedCommand>& commands);

// Completion for shells.
std::string bash_completion(const std::vector<DescribedCommand>& commands);
std::string zsh_completion(const std::vector<DescribedCommand>& commands);
std::string fish_completion(const std::vector<DescribedCommand>& commands);

/// "a b c".
std::string joined(const std::vector<std::string>& words, const std::string& between);

/// `text` with every `from` replaced.
std::string replaced(std::string text, const std::string& from, const std::string& to);

}  // namespace taut::package
