// The common base of commands: registration, options, and the way to say that they are misused. The
// parser's library, which takes seconds of every file that includes it, stays behind command.cpp.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/program/output.h"
#include "sim/motion/printable.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace taut::program {

/// Options that every command takes.
struct Common {
  bool quiet = false;  // no progress and no notes on standard error; errors remain
  bool json = false;   // the result on standard output as JSON
  int threads = 0;     // 0: as many as the machine has
};

/// Options that parse but make no sense together or for this scene: exit code 2.
class Misuse : public std::runtime_error {
 public:
  explicit Misuse(const std::string& message) : std::runtime_error(printable(message)) {}
};

/// Filled while options are parsed; run() does the chosen command's work and returns an exit code.
struct Program {
  Common common;
  std::function<int()> run;
};

/// An option of a command, and what else is true of it. Each call returns the option.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  /// The values allowed.
  Option& range(double least, double most);
  Option& positive();
  Option& one_of(const std::vector<std::string>& values);
  Option& existing_folder();

  Option& required(bool is = true);
  Option& delimiter(char between);                 // one word may hold several values
  Option& one_value_each();                        // several only by naming the option again
  Option& excludes(const Option& other);           // they are not given together
  Option& type_name(const std::string& of_value);  // as --help calls it

 private:
  CLI::Option* option_;
};

/// A command while its options are told.
class Command {
 public:
  explicit Command(CLI::App& app) : app_(&app) {}

  /// The option's value goes into `value` while options are parsed: text, a whole or other number,
  /// a list of these, or an optional one. `names` without dashes stand at a place, not behind a
  /// name.
  template <class Value>
  Option add_option(const std::string& names, Value& value, const std::string& help);
  Option add_flag(const std::string& names, bool& value, const std::string& help);
  /// A number of bytes, as in 8GB.
  Option add_size(const std::string& names, double& bytes, const std::string& help);
  /// `take` reads the text, and throws Misuse where it has no meaning.
  Option add_text(const std::string& names, std::function<void(const std::string&)> take,
                  const std::string& help);
  /// Adds a section below the examples of --help.
  void add_help(const std::string& section);
  /// Sets the function to call once all options are parsed.
  void callback(std::function<void()> chosen);

 private:
  CLI::App* app_;
};

/// Adds a command with the common options. `examples` ends its --help.
Command add_command(CLI::App& app, Program& program, const std::string& name,
                    const std::string& summary, const std::string& examples);

// Which frames of a clip are asked for.

/// Reads "A-B,C": frame numbers and inclusive ranges, each below `total`; rising, without repeats.
/// No text means every frame. Throws Misuse.
std::vector<int> frame_list(const std::optional<std::string>& text, int total);

/// Reads "WxH". Throws Misuse.
std::pair<int, int> picture_size(const std::string& text);

}  // namespace taut::program
