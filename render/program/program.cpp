#include "render/program/program.h"

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "render/base/interrupt.h"
#include "render/base/version.h"
#include "render/program/command.h"
#include "render/program/help.h"
#include "render/program/output.h"
#include "scenes/files/error.h"
#include "scenes/format/document.h"
#include "sim/interventions/interventions.h"
#include "sim/motion/printable.h"
#include "sim/motion/stop.h"
#include "sim/run/method.h"

namespace taut::program {
namespace {

constexpr const char* kExamples = R"(Examples:
  taut new swing --like rope                      a scene of your own, to change and render
  taut demo                                       a first picture within seconds, then a clip
  taut render scenes/nunchaku.toml                its clip, in out/nunchaku
  taut check scenes/nunchaku.toml                 validate a scene and estimate its cost
  taut simulate scenes/nunchaku.toml --csv t.csv  its trajectory, without pictures
  taut COMMAND --help                             more about one command
  taut simulate --help                            its options and the settings of every method

Files that a scene names are looked for in --assets, in the folders of the environment's TAUT_ASSETS
(separated by colons), beside the scene, in its project (the nearest folder above it with a
CMakePresets.json or .git), in share/taut where taut is installed, and in the project in which taut
was built.

Results go to standard output, messages to standard error. Exit codes: 0 done, 1 a golden or answer
differs, 2 usage, 3 bad scene or asset, 4 no rendering context, 5 FFmpeg missing or failed, 6
output could not be written, 7 the simulation diverged, 8 out of memory, 130 interrupted, 143
terminated.)";

ExitCode say_out_of_memory() {
  std::fputs("taut: out of memory\n", stderr);  // which takes none
  return kNoMemory;
}

std::terminate_handler terminate_before = nullptr;

void terminate_for_memory() {
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    render::remove_leftovers();
    _exit(say_out_of_memory());
  } catch (...) {  // a defect
  }
  terminate_before();
}

/// Memory may run out where nothing can catch it, as in what the option parser makes before main():
/// this runs before that.
[[gnu::constructor(101)]] void name_what_terminates() {
  terminate_before = std::set_terminate(terminate_for_memory);
}

const char* cause_of(int code) {
  switch (code) {
    case kUsage:
      return "usage";
    case kBadScene:
      return "bad scene or asset";
    case kNoContext:
      return "no rendering context";
    case kEncoder:
      return "FFmpeg missing or failed";
    case kCannotWrite:
      return "output could not be written";
    case kDiverged:
      return "the simulation diverged";
    case kInterrupted:
      return "interrupted";
    case kTerminated:
      return "terminated";
    default:
      return "internal error";
  }
}

nlohmann::ordered_json json_of(const scenes::SceneFault& fault) {
  const scenes::FaultPlace& place = fault.place;
  nlohmann::ordered_json json = {
      {"file", place.file}, {"key", place.key}, {"message", place.fault}};
  if (place.line > 0) json.update({{"line", place.line}, {"column", place.column}});
  return json;
}

std::string more_text(const scenes::Faults& faults) {
  const std::string file = printable(faults.first.front().place.file);
  return faults.more ? fmt::format("{}: and {} more", file, *faults.more)
                     : fmt::format("{}: and perhaps more, which have not been looked for", file);
}

/// Says what went wrong; `faults` are those of a scene.
int complain(const Common& common, ExitCode code, const std::string& message,
             const scenes::Faults& faults = {}) {
  const auto say = [](std::string_view what) {
    if (is_colored(STDERR_FILENO)) {
      note("\033[1;31mtaut:\033[0m {}\n", Lines{what});
    } else {
      note("taut: {}\n", Lines{what});
    }
  };
  if (faults.first.size() > 1) {
    for (const scenes::SceneFault& fault : faults.first) say(fault.what());
    if (faults.more != 0u) say(more_text(faults));
  } else {
    say(message);
  }
  if (!common.json) return code;
  nlohmann::ordered_json error = {
      {"exit_code", int(code)}, {"cause", cause_of(code)}, {"message", message}};
  for (const scenes::SceneFault& fault : faults.first) error["faults"].push_back(json_of(fault));
  if (!faults.more) error["all_faults"] = false;
  if (faults.more.value_or(0) > 0) error["more_faults"] = *faults.more;
  // The error is told already where this fails, too.
  try {
    render::write_output(json_text(nlohmann::ordered_json({{"error", error}})) + "\n");
  } catch (const render::CannotWrite&) {
  }
  return code;
}

/// Opens those of standard input, output and error that are closed, so that no output gets their
/// numbers and the program's words. Writing there still fails.
void open_standard_streams() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(number, F_GETFD) < 0) open("/dev/null", O_RDONLY);
}

/// The word unknown to the option parser, with the word meant; empty where another thing is wrong.
std::string unknown_word(const CLI::App& app) {
  std::vector<std::string_view> known;
  const std::vector<const CLI::App*> chosen = [&] {
    std::vector<const CLI::App*> list;
    for (const CLI::App* command : app.get_subcommands()) list.push_back(command);
    return list;
  }();
  const std::vector<std::string> left = app.remaining(true);
  if (left.empty()) return {};
  const bool is_option = left.front().starts_with("-");
  std::vector<std::string> names;
  const CLI::App& from = chosen.empty() ? app : *chosen.front();
  if (is_option) {
    for (const CLI::Option* option : from.get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  } else if (chosen.empty()) {
    for (const CLI::App* command : app.get_subcommands(nullptr))
      names.push_back(command->get_name());
  } else {
    return {};
  }
  for (const std::string& name : names) known.push_back(name);
  const std::string word = left.front().substr(0, left.front().find('='));
  const std::string of = chosen.empty() ? "" : " of taut " + from.get_name();
  return is_option ? fmt::format("{} is no option{}{}", word, of, scenes::suggestion(word, known))
                   : fmt::format("{} is no command{}", word, scenes::suggestion(word, known));
}

/// Tells what is wrong with the options, as with everything else.
int complain_of_options(const Common& common, const CLI::App& app, const CLI::ParseError& error) {
  const std::string word = unknown_word(app);
  const CLI::App* chosen = app.get_subcommands().empty() ? &app : app.get_subcommands().front();
  const std::string help = chosen == &app ? "taut" : "taut " + chosen->get_name();
  const std::string why = word.empty() ? error.what() : word;
  return complain(common, kUsage, fmt::format("{} ({} --help says more)", printable(why), help));
}

/// Help or the version, on standard output.
int say_what_is_asked(const CLI::App& app, const CLI::ParseError& asked) {
  return guarded({}, [&] {
    std::ostringstream text;
    app.exit(asked, text, text);
    render::write_output(text.str());
    return kDone;
  });
}

/// Commands that have another name now. The old one still works, with a note.
constexpr std::pair<std::string_view, const char*> kRenamed[] = {{"judge", "classify"},
                                                                 {"reach", "work-precision"}};

/// The name that a renamed command has now; null: `name` is not one.
const char* new_name(std::string_view name) {
  for (const auto& [before, now] : kRenamed) {
    if (name == before) return now;
  }
  return nullptr;
}

int parse_and_run(int argc, char** argv, std::span<const AddCommand> commands) {
  CLI::App app;
  Program program;
  describe_program(app, program, commands);
  std::vector<const char*> words(argv, argv + argc);
  const char* now = argc > 1 ? new_name(argv[1]) : nullptr;
  if (now) words[1] = now;
  try {
    app.parse(argc, words.data());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return say_what_is_asked(app, error);
    // Nothing is parsed that would say so.
    for (int i = 1; i < argc; ++i) program.common.json |= std::string_view(argv[i]) == "--json";
    return complain_of_options(program.common, app, error);
  }
  if (now && !program.common.quiet) note("taut: {} is called {} now\n", argv[1], now);
  return guarded(program.common, [&] {
    render::catch_interrupts();
    set_stop_check(render::stop_if_interrupted);
    return program.run();
  });
}

}  // namespace

int guarded(const Common& common, const std::function<int()>& work) {
  try {
    return work();
  } catch (const Misuse& error) {
    return complain(common, kUsage, error.what());
  } catch (const BadScenes& error) {
    return complain(common, kBadScene, error.what(), error.faults);
  } catch (const scenes::SceneFault& error) {
    return complain(common, kBadScene, error.what(), {{error}});
  } catch (const scenes::BadScene& error) {
    return complain(common, kBadScene, error.what());
  } catch (const BadIntervention& error) {
    return complain(common, kBadScene, error.what());
  } catch (const scenes::BadAsset& error) {
    return complain(common, kBadScene, error.what());
  } catch (const render::NoContext& error) {
    return complain(common, kNoContext, error.what());
  } catch (const render::EncoderFailed& error) {
    return complain(common, kEncoder, error.what());
  } catch (const render::CannotWrite& error) {
    return complain(common, kCannotWrite, error.what());
  } catch (const Diverged& error) {
    return complain(common, kDiverged, error.what());
  } catch (const render::Interrupted& error) {
    const std::string far = left_off().empty() ? "" : "; " + left_off();
    return complain(common, error.signal == SIGINT ? kInterrupted : kTerminated,
                    error.what() + far);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::not_enough_memory) throw std::bad_alloc();
    return complain(common, kInternal, fmt::format("internal error: {}", error.what()));
  } catch (const std::exception& error) {
    return complain(common, kInternal, fmt::format("internal error: {}", error.what()));
  } catch (...) {
    return complain(common, kInternal, "internal error");
  }
}

void describe_program(CLI::App& app, Program& program, std::span<const AddCommand> commands) {
  app.name("taut");
  app.description("Simulates flexible connectors (ropes, chains, cords) and renders them.");
  app.require_subcommand(1);
  app.formatter(help_format());
  app.set_version_flag("--version", fmt::format("taut {}", render::version()));
  app.footer(std::string("\n") + kExamples);
  for (const AddCommand add : commands) add(app, program);
}

int run_words(const Common& common, AddCommand add, std::vector<std::string> words) {
  CLI::App app;
  Program program;
  add(app, program);
  std::ranges::reverse(words);  // as CLI11 takes them
  app.parse(words);
  program.common = common;
  return program.run();
}

int run_program(int argc, char** argv, std::span<const AddCommand> commands) {
  open_standard_streams();
  try {
    return parse_and_run(argc, argv, commands);
  } catch (const std::bad_alloc&) {
    return say_out_of_memory();
  }
}

namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kBetween{100};  // looks

/// When each was written last; editors may take a file away for a moment.
std::vector<fs::file_time_type> times_of(const std::vector<fs::path>& files) {
  std::vector<fs::file_time_type> times;
  std::error_code error;
  for (const fs::path& file : files) times.push_back(fs::last_write_time(file, error));
  return times;
}

}  // namespace

int watch(const std::function<std::vector<fs::path>()>& files, const Common& common,
          const std::function<int()>& work) {
  for (;;) {
    const std::vector<fs::path> watched = files();
    const auto seen = times_of(watched);
    const int code = guarded(common, work);
    if (code == kInterrupted || code == kTerminated) return kDone;
    while (times_of(watched) == seen) {
      if (render::pending_interrupt()) return kDone;
      std::this_thread::sleep_for(kBetween);
    }
  }
}

}  // namespace taut::program
