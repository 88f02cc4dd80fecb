#include "render/cli/program.h"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>

#include "render/cli/command.h"
#include "render/error.h"
#include "render/interrupt.h"
#include "scenes/error.h"
#include "sim/method.h"
#include "sim/timeline.h"

namespace taut::cli {

namespace {

constexpr const char* kExamples = R"(Examples:
  taut render scenes/nunchaku.toml                its clip, in out/nunchaku
  taut check scenes/nunchaku.toml                 what is wrong with a scene, and what it would do
  taut simulate scenes/nunchaku.toml --csv t.csv  its trajectory, without pictures
  taut COMMAND --help                             more about one command

Results go to standard output, messages to standard error. Exit codes: 0 done, 1 a golden differs,
2 usage, 3 bad scene or asset, 4 no rendering context, 5 FFmpeg missing or failed, 6 output could
not be written, 7 the simulation diverged, 130 interrupted, 143 terminated.)";

int complain(ExitCode code, const std::exception& error) {
  fmt::print(stderr, "taut: {}\n", error.what());
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
  } catch (const std::exception& error) {
    fmt::print(stderr, "taut: internal error: {}\n", error.what());
    return kInternal;
  }
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
  command.footer("\nExamples:\n" + examples);
  return command;
}

int run_program(int argc, char** argv, std::initializer_list<AddCommand> commands) {
  CLI::App app("Simulates flexible connectors (ropes, chains, cords) and renders them.", "taut");
  app.require_subcommand(1);
  app.footer(std::string("\n") + kExamples);
  Program program;
  for (const AddCommand add : commands) add(app, program);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  return run(program);
}

}  // namespace taut::cli
