#include "render/cli/program.h"

#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "render/cli/command.h"
#include "render/cli/note.h"
#include "render/error.h"
#include "render/interrupt.h"
#include "scenes/asset_path.h"
#include "scenes/error.h"
#include "sim/method.h"
#include "sim/timeline.h"

namespace taut::cli {

namespace {

constexpr const char* kExamples = R"(Examples:
  taut demo                                       a first picture within seconds, then a clip
  taut render scenes/nunchaku.toml                its clip, in out/nunchaku
  taut check scenes/nunchaku.toml                 what is wrong with a scene, and what it would do
  taut simulate scenes/nunchaku.toml --csv t.csv  its trajectory, without pictures
  taut COMMAND --help                             more about one command

Files that a scene names are looked for in --assets, in the folders of the environment's TAUT_ASSETS
(separated by colons), beside the scene, in its project (the nearest folder above it with a
CMakePresets.json or .git), and in share/taut where taut is installed.

Results go to standard output, messages to standard error. Exit codes: 0 done, 1 a golden differs,
2 usage, 3 bad scene or asset, 4 no rendering context, 5 FFmpeg missing or failed, 6 output could
not be written, 7 the simulation diverged, 8 out of memory, 130 interrupted, 143 terminated.)";

ExitCode say_out_of_memory() {
  std::fputs("taut: out of memory\n", stderr);  // which takes none
  return kNoMemory;
}

std::terminate_handler terminate_before = nullptr;

void terminate_for_memory() {
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
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

int complain(ExitCode code, const std::exception& error) {
  note("taut: {}\n", error.what());
  return code;
}

int run(const Program& program) {
  try {
    catch_interrupts();
    return program.run();
  } catch (const Misuse& error) {
    return complain(kUsage, error);
  } catch (const BadScene& error) {
    return complain(kBadScene, error);
  } catch (const BadIntervention& error) {
    return complain(kBadScene, error);
  } catch (const BadAsset& error) {
    return complain(kBadScene, error);
  } catch (const NoContext& error) {
    return complain(kNoContext, error);
  } catch (const EncoderFailed& error) {
    return complain(kEncoder, error);
  } catch (const CannotWrite& error) {
    return complain(kCannotWrite, error);
  } catch (const Diverged& error) {
    return complain(kDiverged, error);
  } catch (const Interrupted& error) {
    return complain(error.signal == SIGINT ? kInterrupted : kTerminated, error);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    note("taut: internal error: {}\n", error.what());
    return kInternal;
  }
}

/// Opens what of standard input, output and error is closed, so that no output gets their numbers
/// and the program's words. What is written there still fails.
void open_standard_streams() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(number, F_GETFD) < 0) open("/dev/null", O_RDONLY);
}

int parse_and_run(int argc, char** argv, std::span<const AddCommand> commands) {
  CLI::App app;
  Program program;
  describe_program(app, program, commands);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  return run(program);
}

}  // namespace

CLI::App& add_command(CLI::App& app, Program& program, const std::string& name,
                      const std::string& summary, const std::string& examples) {
  CLI::App& command = *app.add_subcommand(name, summary);
  command.add_flag("--quiet,-q", program.common.quiet, "No progress, no notes; errors remain");
  command.add_flag("--json", program.common.json, "The result on standard output as JSON");
  command
      .add_option("--threads", program.common.threads,
                  "Threads to draw with, at most (simulating takes one); 0, the default: all")
      ->check(CLI::Range(0, 1024));
  command
      .add_option_function<std::string>(
          "--assets", [](const std::string& folder) { set_asset_folder(folder); },
          "A folder in which the files that a scene names are looked for first")
      ->check(CLI::ExistingDirectory);
  command.footer("\nExamples:\n" + examples);
  return command;
}

void describe_program(CLI::App& app, Program& program, std::span<const AddCommand> commands) {
  app.name("taut");
  app.description("Simulates flexible connectors (ropes, chains, cords) and renders them.");
  app.require_subcommand(1);
  app.footer(std::string("\n") + kExamples);
  for (const AddCommand add : commands) add(app, program);
}

int run_program(int argc, char** argv, std::span<const AddCommand> commands) {
  open_standard_streams();
  try {
    return parse_and_run(argc, argv, commands);
  } catch (const std::bad_alloc&) {
    return say_out_of_memory();
  }
}

}  // namespace taut::cli
