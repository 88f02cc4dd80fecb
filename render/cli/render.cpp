// taut render: a scene's clip.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "render/base/atomic_file.h"
#include "render/clip/clip_job.h"
#include "render/film/render_workers.h"
#include "render/options/needs.h"
#include "render/program/command.h"
#include "render/program/program.h"
#include "scenes/load/load_scene.h"

namespace taut::cli {
namespace render_command {
namespace {

int draw_stills(const clips::ClipJob& job, const program::Common& common) {
  film::RenderWorkers workers(job.backend, common.threads, true, job.scene, job.scene.width,
                              job.scene.height, job.options.samples);
  render::write_output(
      clips::make_stills(job.options.stills, job.scene, workers.film(), job.out, job.provenance()));
  return program::kDone;
}

int render(const program::Common& common, const clips::RenderOptions& options) {
  const clips::ClipJob job(options, common);
  if (options.part.merge) return clips::merge_clip(job, common);
  if (options.part.is_part() && job.frames.empty()) {  // there are more parts than frames
    return program::say_part_done(options.part, job.frame_path, 0, common);
  }
  if (job.options.stills.any()) return draw_stills(job, common);
  const clips::DrawnClip clip = clips::draw_clip(job, common);
  if (options.part.is_part()) {
    return program::say_part_done(options.part, job.frame_path, job.frames.size(), common);
  }
  render::write_output(clips::result_text(clip.report, common));
  if (!common.json) render::write_output(clip.profile);
  return program::kDone;
}

int render_or_watch(const program::Common& common, const clips::RenderOptions& options) {
  if (!options.output.watch) return render(common, options);
  if (options.scene == "-" || options.inputs.several()) {
    throw program::Misuse("--watch: expected one scene file");
  }
  return program::watch([&] { return scenes::scene_files(options.scene); }, common,
                        [&] { return render(common, options); });
}

}  // namespace
}  // namespace render_command

void add_render(CLI::App& app, program::Program& program) {
  using namespace render_command;
  program::Command command = program::add_command(
      app, program, "render", "Render a scene's clip",
      "  taut render scenes/nunchaku.toml\n"
      "  taut render scenes/nunchaku.toml --preview\n"
      "  taut render scenes/nunchaku.toml -o nunchaku.webp --preset draft\n"
      "  taut render scenes/rope_swing.toml --set connectors.rope.length=0.3 --watch\n"
      "  taut render scenes/nunchaku.toml --frames 0-59,120 --size 960x540 --no-video\n"
      "  taut render scenes/nunchaku.toml --resume\n\n" +
          std::string(studies::kEstimateHelp) +
          "\nclip.json has it: error_estimate_m, predictable_until_s, "
          "estimate_ms_per_second.");
  auto options = std::make_shared<clips::RenderOptions>();
  options::add_scene_options(command, options->inputs, false);
  command.add_option("--out", options->out,
                     "The clip's folder; default: in out/, by the scene's path");
  clips::add_output_options(command, options->output);
  command.add_option("--frames", options->frames, "Frames to draw, as A-B,C; default: all");
  command.add_option("--size", options->size, "WxH in pixels; default: the scene's");
  command.add_option("--fps", options->fps, "Frames per second; default: the scene's")
      .range(1, 1000);
  command
      .add_option("--samples", options->samples, "Samples per pixel; default: the preset's, or 4")
      .range(1, 64);
  options::add_method_options(command, options->method);
  command.add_flag("--no-estimate", options->no_estimate, "Do not estimate the run's own error");
  options::add_memory_option(command, options->max_memory);
  command.add_flag("--certificate", options->certificate,
                   "Print on the picture what is proved about the clip, or that nothing is");
  command.add_option("--backend", options->backend, "OpenGL backend: auto, egl or osmesa")
      .one_of({"auto", "egl", "osmesa"});
  const program::Option resume = command.add_flag(
      "--resume", options->resume, "Keep finished frames that would not change (default)");
  command.add_flag("--anew", options->anew, "Draw every frame again").excludes(resume);
  program::add_part_options(command, options->part, "frames");
  command.add_flag("--contact-sheet", options->stills.contact_sheet,
                   "Make only contact_sheet.png, with a picture from the middle of each caption");
  command
      .add_option("--every", options->stills.every,
                  "Interval of the sheet's pictures, s, instead of captions")
      .positive();
  command.add_option("--poster", options->stills.poster,
                     "Make only poster.png, the picture at this time of the clip, s");
  command.add_flag(
      "--profile", options->profile,
      "Time a frame's stages one after another, and print their medians and lower bounds");
  command.add_flag("--no-video", options->no_video, "Write frames, no video");
  command
      .add_option("--patience", options->patience,
                  "Seconds after which an idle FFmpeg is abandoned; default: 60")
      .positive();
  command.callback([&program, options] {
    program.run = [&program, options] {
      return options::for_each_scene(options->inputs, program.common,
                                     [&](const std::string& scene) {
                                       clips::RenderOptions one = *options;
                                       one.scene = scene;
                                       return render_or_watch(program.common, one);
                                     });
    };
  });
}

}  // namespace taut::cli
