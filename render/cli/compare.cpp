// taut compare: methods side by side in one clip, judged by the truth or by what must hold.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/clip/compare_methods.h"
#include "render/film/frame_folder.h"
#include "render/film/video.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/output.h"

namespace taut::cli {
namespace compare_command {
namespace {

constexpr std::size_t kCells = 6;  // unless --methods chooses

struct Options {
  options::StudyOptions study;
  std::optional<std::string> frames;
  std::string size, backend = "auto", times;
  int fps = 0, samples = 4, slower = 0;  // 0: by the scene
  bool no_video = false, over = false;
};

/// The contenders asked for; otherwise every method that this build has and that follows the world,
/// and forms of them until six cells are full.
std::vector<options::Contender> contenders(const options::StudyOptions& options,
                                           const World& world) {
  std::vector<options::Contender> all = options::contenders_on(options, world);
  if (!options.methods.empty()) return all;
  std::erase_if(all, [](const options::Contender& c) { return !c.method->missing.empty(); });
  const auto is_form = [](const options::Contender& c) {
    return c.label.find(':') != std::string::npos;
  };
  std::vector<options::Contender> chosen;
  for (const bool form : {false, true})
    for (const options::Contender& one : all)
      if (is_form(one) == form && chosen.size() < kCells) chosen.push_back(one);
  return chosen;
}

std::string report(const Options& options, const scenes::Scene& scene,
                   const film::Comparison& comparison, const std::string& video) {
  program::Json json = {{"scene", options.study.scene},
                        {"title", scene.title},
                        {"size_px", {scene.width, scene.height}},
                        {"fps", scene.fps},
                        {"slower", comparison.slower},
                        {"horizon_s", comparison.horizon},
                        {"self_error_m", comparison.self_error},
                        {"judged_by_truth", comparison.by_truth},
                        {"result", fmt::format("{}.", fmt::join(comparison.result, "; "))},
                        {"methods", program::Json::array()}};
  for (const film::ComparedMethod& method : comparison.methods) {
    json["methods"].push_back(
        {{"method", method.label},
         {"settings", method.settings},
         {"frames", method.frames},
         {"failure", method.failure},
         {"verdict", method.verdict.text},
         {"right", method.verdict.grade == film::Verdict::Grade::none
                       ? program::Json(nullptr)
                       : program::Json(method.verdict.grade == film::Verdict::Grade::kept)},
         {"from_dynamic_constraints_mm", program::number_or_null(1e3 * method.from_constraints)},
         {"from_truth_mm", program::number_or_null(1e3 * method.from_truth)},
         {"stretch_max", program::number_or_null(method.stretch_max)},
         {"energy_drift", program::number_or_null(method.drift)},
         {"cpu_us_per_frame", program::number_or_null(method.cpu_us)}});
  }
  if (!video.empty()) json["video"] = video;
  return program::json_text(json) + "\n";
}

int compare(const program::Common& common, const Options& options) {
  scenes::Scene scene = options::study_scene(options.study, {}, true);
  if (options.fps > 0) scene.fps = options.fps;
  if (!options.size.empty())
    std::tie(scene.width, scene.height) = program::picture_size(options.size);
  options::complete_stage(scene, options::scene_changes(options.study.inputs.set), common);
  options::tell_left_out(scene, common);
  if (!options.no_video && (scene.width % 2 || scene.height % 2))
    throw program::Misuse(
        fmt::format("a video of {}x{} is not possible: H.264 (yuv420p) needs even sides",
                    scene.width, scene.height));
  const std::vector<options::Contender> chosen = contenders(options.study, scene.world);
  clips::CompareSettings settings{.quiet = common.quiet};
  if (options.slower > 0) settings.slower = options.slower;
  if (!options.times.empty()) settings.times = clips::cpu_times(options.times);
  // The clip's length is known once methods are judged; what no clip can have is refused before.
  if (options.frames)
    program::frame_list(
        options.frames,
        int(film::most_moments(std::size_t(scene.frames()), scene.fps,
                               settings.slower.value_or(clips::kSlower), chosen.size())));
  if (!options.no_video) film::require_ffmpeg();

  const std::string name = options::scene_name(options.study.scene);
  const std::filesystem::path out = options::results_folder(
      options.study.scene, options.study.out, options.study.inputs.several(), "out/compare");
  const gl::Context context(gl::backend_named(options.backend), common.threads);
  const std::string layout = options.over ? "_over" : "";
  film::FrameFolder folder(out / ("frames" + layout), false, {scene.width, scene.height});
  const film::Comparison comparison = clips::compare_methods(scene, chosen, settings);
  const std::vector<film::Moment> moments = film::moments_of(comparison);
  const std::vector<int> frames = program::frame_list(options.frames, int(moments.size()));
  film::ComparisonFilm film(context, scene, comparison, scene.width, scene.height, options.samples,
                            options.over ? film::Layout::over : film::Layout::beside);
  std::vector<std::filesystem::path> files;
  {
    program::Progress progress("rendering", "frames", frames.size(), common.quiet);
    const std::uint64_t fingerprint = film::program_fingerprint();
    for (const int frame : frames) {
      render::stop_if_interrupted();
      folder.put(frame, fingerprint, film.draw(moments[std::size_t(frame)]));
      files.push_back(folder.file(frame));
      progress.update(files.size());
    }
    folder.finish();
  }
  std::string video;
  if (!options.no_video) {
    video = (out / (name + layout + ".mp4")).string();
    film::encode_video(files, scene.fps, video);
  }
  options::write_csv(comparison.table, out / "compare");
  const std::string json = report(options, scene, comparison, video);
  render::AtomicFile record(out / "compare.json");
  record.write(json);
  record.commit();
  render::write_output(common.json ? json : program::table_text(comparison.table));
  if (!common.quiet)
    program::note("{}\n", video.empty() ? (out / ("frames" + layout)).string() : video);
  return program::kDone;
}

}  // namespace
}  // namespace compare_command

void add_compare(CLI::App& app, program::Program& program) {
  using namespace compare_command;
  program::Command command = program::add_command(
      app, program, "compare",
      "Show methods side by side in one clip: which is right, how wrong others are, the costs",
      "  taut compare scenes/rope_drop.toml\n"
      "  taut compare scenes/rope_swing.toml --methods impulse,impulse:as-printed,direct\n"
      "  taut compare scenes/rope_drop.toml --over\n"
      "  taut compare scenes/rope_swing.toml --frames 0-30 --size 960x540 --no-video\n"
      "  taut compare scenes/rope_drop.toml --times out/compare/rope_drop/compare.json");
  auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->study.inputs);
  command.add_option("--out", options->study.out,
                     "The clip's folder; default: in out/compare, by the scene's path");
  command
      .add_option("--methods", options->study.methods,
                  "Methods to compare, METHOD or METHOD:FORM, separated by commas; default: six")
      .delimiter(',');
  command.add_option("--frames", options->frames,
                     "Frames of the clip to draw, as A-B,C, from 0; default: all");
  command
      .add_option("--slower", options->slower,
                  "Begin N times slower than real time, with stops at the worst moments; default: "
                  "6 if the motion is not predictable, else 1")
      .range(1, 100);
  command.add_option(
      "--times", options->times,
      "Use CPU times from an earlier run's compare.json, so that pictures are reproducible");
  command.add_option("--size", options->size, "WxH in pixels; default: the scene's");
  command.add_option("--fps", options->fps, "Frames per second; default: the scene's")
      .range(1, 1000);
  command.add_option("--samples", options->samples, "Samples per pixel; default: 4").range(1, 64);
  command.add_option("--backend", options->backend, "OpenGL backend: auto, egl or osmesa")
      .one_of({"auto", "egl", "osmesa"});
  command.add_flag("--over", options->over,
                   "Draw all methods in one panel, each in its colour, instead of side by side");
  command.add_flag("--no-video", options->no_video, "Write frames, no video");
  options->study.features = options::study_features("compare");
  command.callback([&program, options] {
    program.run = [&program, options] {
      return options::for_each_study(options->study, program.common,
                                     [&](const options::StudyOptions& one) {
                                       Options of_one = *options;
                                       of_one.study = one;
                                       return compare(program.common, of_one);
                                     });
    };
  });
}

}  // namespace taut::cli
