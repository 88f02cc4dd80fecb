// taut demo: the demonstration that taut comes with, a first picture within seconds.
#include <filesystem>

#include "render/cli/commands.h"
#include "render/program/output.h"
#include "scenes/files/files.h"

namespace taut::cli {
namespace demo_command {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = "scenes/nunchaku.toml";

struct Options {
  std::string out = "out/nunchaku";
  bool preview = false;
};

/// `taut render` of `scene` with these words behind it.
int render(const program::Common& common, const fs::path& scene, const fs::path& out,
           std::vector<std::string> words) {
  words.insert(words.begin(), {"render", scene.string(), "--out", out.string()});
  return program::run_words(common, add_render, std::move(words));
}

int demo(const program::Common& common, const Options& options) {
  const fs::path scene = scenes::shipped_file(kScene), out = options.out, preview = out / "preview";
  if (!common.quiet) program::note("a picture and five small seconds first, then the clip\n");
  int code = render(common, scene, preview, {"--poster", "6.9", "--size", "960x540"});
  if (code == program::kDone)
    code = render(common, scene, preview,
                  {"--size", "480x270", "--fps", "24", "--frames", "96-215", "--samples", "2",
                   "--no-estimate"});
  if (code == program::kDone && !options.preview) code = render(common, scene, out, {});
  return code;
}

}  // namespace
}  // namespace demo_command

void add_demo(CLI::App& app, program::Program& program) {
  using namespace demo_command;
  program::Command command = program::add_command(
      app, program, "demo", "Render the demonstration that taut comes with",
      "  taut demo               out/nunchaku: a picture and a small clip within "
      "seconds, then the clip\n"
      "  taut demo --preview     the picture and the small clip alone");
  auto options = std::make_shared<Options>();
  command.add_option("--out", options->out, "The clip's folder; default: out/nunchaku");
  command.add_flag("--preview", options->preview, "Make only the picture and the small clip");
  command.callback([&program, options] {
    program.run = [&program, options] { return demo(program.common, *options); };
  });
}

}  // namespace taut::cli
