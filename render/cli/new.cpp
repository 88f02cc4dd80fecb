// taut new: a scene to begin with.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "render/cli/commands.h"
#include "render/options/method_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "scenes/files/files.h"

namespace taut::cli {
namespace new_command {
namespace {

namespace fs = std::filesystem;

/// Each is a file of scenes/new.
const std::vector<std::string> kKinds{"rope", "chain", "net", "crane", "nunchaku", "character"};

struct Options {
  std::string name, like = "rope";
  bool anew = false;
};

/// NAME.toml. Throws Misuse if the name is none of a file.
fs::path file_of(const std::string& name) {
  const fs::path file = name;
  const std::string last = file.filename().string();
  if (last.empty() || last == "." || last == "..")
    throw program::Misuse(fmt::format("{}: is no name of a file, expected one as in swing", name));
  return file.extension() == ".toml" ? file : fs::path(name + ".toml");
}

int run(const Options& options, const program::Common& common) {
  const std::string scene =
      scenes::read_bytes(scenes::shipped_file(fs::path("scenes/new") / (options.like + ".toml")));
  if (options.name == "-") {
    if (common.json) throw program::Misuse("-: standard output is the JSON's (--json)");
    render::write_output(scene);
    return program::kDone;
  }
  const fs::path file = file_of(options.name);
  std::error_code error;
  if (!options.anew && fs::exists(fs::symlink_status(file, error)))
    throw render::CannotWrite(
        fmt::format("{}: is there already, expected another name or --anew", file.string()));
  render::AtomicFile output(file);
  output.write(scene);
  output.commit();
  const auto lines = std::ranges::count(scene, '\n');
  if (common.json) {
    const program::Json json = {{"scene", file.string()}, {"like", options.like}, {"lines", lines}};
    render::write_output(program::json_text(json) + "\n");
    return program::kDone;
  }
  render::write_output(file.string() + "\n");
  if (!common.quiet)
    program::note(
        "like {}, {} lines; look at the clip, change a line, look again:\n"
        "  taut render {} --preview\n",
        options.like, lines, options::quoted(file.string()));
  return program::kDone;
}

}  // namespace
}  // namespace new_command

void add_new(CLI::App& app, program::Program& program) {
  using namespace new_command;
  program::Command command =
      program::add_command(app, program, "new", "Write a scene of your own to begin with",
                           R"(  taut new swing                  swing.toml: a rope lets a ball swing
  taut new fence --like chain     fence.toml: a chain between two posts comes loose
  taut new ball --like character  ball.toml: a figure swings a ball on a rope
  taut new - --like crane         to standard output

Writes a scene of at most 30 lines, with comments, that is ready to render:

  taut render swing.toml --preview      a small clip within seconds, out/swing/preview
  taut render swing.toml                its clip, out/swing/swing.mp4
  taut check swing.toml                 validate it, estimate the time

An existing file is replaced only with --anew. Exit codes: 0 written, 2 NAME is no name of a file,
3 the scenes that come with taut are missing, 6 the file exists or cannot be written.)");
  const auto options = std::make_shared<Options>();
  command
      .add_option("NAME", options->name,
                  "Scene to write: NAME.toml, in a folder if you like; - is standard output")
      .required();
  command
      .add_option("--like", options->like,
                  "Kind of scene: rope (default), chain, net, crane, nunchaku, character")
      .one_of(kKinds);
  command.add_flag("--anew", options->anew, "Replace an existing file");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
