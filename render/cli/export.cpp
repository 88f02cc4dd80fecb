// taut export: a scene's motion for other programs.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "render/base/interrupt.h"
#include "render/export/csv.h"
#include "render/export/frame_writer.h"
#include "render/export/npz.h"
#include "render/options/method_options.h"
#include "render/options/needs.h"
#include "render/options/scene_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "scenes/scene/scene.h"
#include "sim/motion/printable.h"

namespace taut::cli {
namespace export_command {
namespace {

namespace fs = std::filesystem;

struct Options {
  options::SceneOptions inputs;
  std::string scene, to, out;
  int fps = 0;  // 0: the scene's
  bool scenery = false;
  double max_memory = 0;
  options::MethodOptions method;
};

struct Format {
  std::string_view name;
  bool binary;
  bool stage;             // it shows what things look like
  bool gathers;           // it keeps all states until the last has come
  double bytes_a_number;  // roughly, of a frame as a file
  std::unique_ptr<exporting::FrameWriter> (*writer)(const scenes::Scene& scene,
                                                    exporting::WriteBytes write);
};

constexpr Format kFormats[] = {
    {"glb", true, true, true, 40, exporting::glb_writer},
    {"usda", false, true, true, 60, exporting::usda_writer},
    {"npz", true, false, true, 16, exporting::npz_writer},
    {"csv", false, false, false, 19, exporting::csv_writer},
    {"pc2", true, false, false, 4, exporting::pc2_writer},
    {"bvh", false, true, false, 19, exporting::bvh_writer},
};

std::vector<std::string> format_names() {
  std::vector<std::string> names;
  for (const Format& format : kFormats) names.emplace_back(format.name);
  return names;
}

std::string output_file(const Options& options, const Format& format) {
  const std::string suffix = fmt::format(".{}", format.name);
  if (options.out.empty()) {
    return (options::results_folder(options.scene, "", false) /
            (options::scene_name(options.scene) + suffix))
        .string();
  }
  if (!options.inputs.several()) return options.out;
  if (fs::path(options.out).has_extension() || program::to_standard_output(options.out)) {
    throw program::Misuse(
        fmt::format("-o {}: one file for several scenes, expected a folder", options.out));
  }
  return options::results_folder(options.scene, options.out, true).string() + suffix;
}

/// The format that was named or, where none was, that of the file's suffix.
const Format& chosen_format(const Options& options) {
  const std::string suffix = fs::path(options.out).extension().string();
  const std::string name = !options.to.empty() ? options.to
                           : suffix.empty()    ? suffix
                                               : suffix.substr(1);
  for (const Format& format : kFormats)
    if (format.name == name) return format;
  throw program::Misuse(fmt::format(
      "{}, expected --to with one of {}",
      options.out.empty() ? "no format is given" : options.out + ": its suffix names no format",
      fmt::join(format_names(), ", ")));
}

options::Needs needs_of(const scenes::Scene& scene, const Format& format) {
  options::Needs needs = options::simulation_needs(scene);
  constexpr double kCsvNumber = 19;  // bytes, of the disk that simulating needs
  needs.disk *= format.bytes_a_number / kCsvNumber;
  if (format.gathers) needs.memory += 2 * needs.disk;
  return needs;
}

/// No format here has pictures.
void tell_textures(const scenes::Stage& stage) {
  std::set<std::string> told;
  for (const auto* models : {&stage.scenery, &stage.body_models, &stage.characters}) {
    for (const auto& model : *models) {
      if (model && !model->textures.empty() && told.insert(model->name).second) {
        program::note("warning: {}: its textures are not exported\n", printable(model->name));
      }
    }
  }
}

int run(const Options& options, const program::Common& common) {
  const Format& format = chosen_format(options);
  scenes::Scene scene = options::load_chosen(options.scene, format.stage, options.method);
  if (options.fps > 0) scene.fps = options.fps;
  scene.method = options::chosen_method(options.method, scene);
  scenes::settle_breaks(scene);
  const std::string name = output_file(options, format);
  const bool to_output = program::to_standard_output(name);
  if (to_output && common.json) {
    throw program::Misuse(fmt::format("-o {}: standard output is the JSON's (--json)", name));
  }
  if (to_output && format.binary && isatty(STDOUT_FILENO)) {
    throw program::Misuse(
        fmt::format("-o {}: {} is no text, and standard output is a terminal; expected "
                    "a pipe or a file",
                    name, format.name));
  }
  const fs::path folder = fs::path(name).has_parent_path() ? fs::path(name).parent_path() : ".";
  options::refuse_beyond(needs_of(scene, format), scene, options.max_memory,
                         to_output ? "" : folder, "", common.quiet);
  if (format.stage) options::complete_stage(scene, options::chosen_changes(options.method), common);
  options::tell_left_out(scene, common);
  if (!common.quiet && scene.stage) tell_textures(*scene.stage);
  if (scene.stage && !options.scenery) scene.stage->scenery.clear();
  program::Output output(name);
  exporting::Figures figures;
  {
    program::Progress progress("simulating", "frames", std::uint64_t(scene.frames()), common.quiet);
    const auto writer = format.writer(scene, [&](std::string_view bytes) { output.write(bytes); });
    exporting::play(scene, *writer, [&](int frames) {
      render::stop_if_interrupted();
      progress.update(std::uint64_t(frames));
    });
    figures = writer->figures();
  }
  output.finish();
  if (to_output) return program::kDone;
  if (common.json) {
    nlohmann::ordered_json json = {
        {"scene", options.scene},
        {"format", format.name},
        {"file", name},
        {"bytes", output.written()},
        {"method", scene.method.name},
        {"settings", options::settings_json(with_defaults(scene.method))},
        {"frames", scene.frames()},
        {"fps", scene.fps}};
    for (const auto& figure : figures)
      std::visit([&](auto number) { json[figure.first] = number; }, figure.second);
    render::write_output(program::json_text(json) + '\n');
    return program::kDone;
  }
  render::write_output(name + '\n');
  if (!common.quiet) {
    program::note("{} frames, {} a second, method {}, {} bytes\n", scene.frames(), scene.fps,
                  scene.method.name, output.written());
  }
  return program::kDone;
}

}  // namespace
}  // namespace export_command

void add_export(CLI::App& app, program::Program& program) {
  using namespace export_command;
  program::Command command =
      program::add_command(app, program, "export", "Export a scene's motion to other programs",
                           R"(  taut export scenes/nunchaku.toml --to glb
  taut export scenes/rope_swing.toml -o swing.npz
  taut export scenes/rope_swing.toml --to csv -o - | head -1

Formats:
  glb   animated glTF: bodies, characters with their skins, ropes as skinned tubes, chains link by
        link, cameras, the key light; a node NAME.0, NAME.1, ... for every particle
  usda  USD in text: ropes as curves, bodies, cameras, the key light
  npz   arrays for numpy.load(): times, positions, velocities, bodies' positions and rotations
  csv   a table: the rows of taut simulate, without its error estimate
  pc2   a point cache for Blender's Mesh Cache modifier: the particles of all connectors
  bvh   the character's skeleton and its motion

SI units, y up, one state per frame. glb and usda have more states if needed, so that between
frames nothing is more than 0.1 mm from the simulated states (--json: _off_by_m).
The same scene gives the same bytes. render/export/README.md describes each format, and how to open
it in other programs.)");
  const auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->inputs, false);
  command.add_option("--to", options->to, "Format; default: by the suffix of --out")
      .one_of(format_names());
  command
      .add_option("--out,-o", options->out,
                  "Output file, or folder for several scenes; - for standard output; default: "
                  "out/NAME/NAME.FORMAT")
      .type_name("FILE");
  command.add_option("--fps", options->fps, "Frames per second; default: the scene's")
      .range(1, 1000);
  command.add_flag("--scenery", options->scenery, "Include the stage's scenery (glb only)");
  options::add_method_options(command, options->method);
  options::add_memory_option(command, options->max_memory);
  command.callback([options, &program] {
    program.run = [options, &program] {
      return options::for_each_scene(options->inputs, program.common,
                                     [&](const std::string& scene) {
                                       Options one = *options;
                                       one.scene = scene;
                                       return run(one, program.common);
                                     });
    };
  });
}

}  // namespace taut::cli
