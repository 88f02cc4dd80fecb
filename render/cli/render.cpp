// taut render: a scene's clip.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "render/atomic_file.h"
#include "render/caption.h"
#include "render/cli/command.h"
#include "render/cli/frame_list.h"
#include "render/cli/method_options.h"
#include "render/cli/needs.h"
#include "render/cli/note.h"
#include "render/cli/outputs.h"
#include "render/cli/profile_report.h"
#include "render/cli/progress.h"
#include "render/cli/scene_options.h"
#include "render/cli/self_estimate.h"
#include "render/cli/stills.h"
#include "render/cli/terminal.h"
#include "render/cli/watch.h"
#include "render/fingerprint.h"
#include "render/frame_folder.h"
#include "render/interrupt.h"
#include "render/profile.h"
#include "render/render_workers.h"
#include "render/stage_floor.h"
#include "render/table.h"
#include "render/version.h"
#include "render/video.h"
#include "scenes/default_stage.h"
#include "scenes/error.h"
#include "scenes/reader/document.h"
#include "scenes/scene.h"
#include "sim/hash.h"

namespace taut::cli {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Options {
  SceneOptions inputs;
  std::string scene;  // of the inputs, the one that is rendered now
  std::string out, size, backend = "auto";
  std::optional<std::string> frames;
  int fps = 0, samples = 0;  // 0: the preset's, or 4
  double patience = 60;      // s
  double max_memory = 0;
  bool certificate = false, resume = false, anew = false, no_video = false, profile = false;
  bool no_estimate = false;
  Stills stills;
  OutputOptions output;
  MethodOptions method;
};

/// What is proved of the clip at `fps` frames a second.
std::string proof_of(const Scene& scene, const Options& options, int fps) {
  if (!options.method.planned) return "none: the clip is not by a plan (--planned)";
  if (fps != scene.fps) {
    return fmt::format("none: the plan is of {} frames a second, the clip of {}", scene.fps, fps);
  }
  return certificate(*scene.plan);
}

/// The plan's pixels are those of a picture as high as the scene's; of another they are as many
/// more.
void enlarge(Scene& scene, double times, int samples) {
  Plan& plan = *scene.plan;
  if (!plan.tolerance.ends_with("px")) return;
  plan.error *= times;
  if (plan.exposures == 0) return;
  scene.stage->exposures_apart *= times;
  if (plan.exposures > 1) scene.stage->exposures = std::max(scene.stage->exposures, samples);
}

/// Frames that are to be made and are no files yet.
std::size_t missing_frames(const std::filesystem::path& folder, const std::vector<int>& frames) {
  std::error_code error;
  return std::size_t(std::ranges::count_if(frames, [&](int frame) {
    return !std::filesystem::exists(folder / fmt::format("{:06}.png", frame), error);
  }));
}

constexpr const char* kFewer = ", fewer frames at a time (--frames), smaller pictures (--size)";

/// The options of a single picture, where one is asked for in whatever way.
Stills stills_of(const Options& options, double duration) {
  Stills stills = options.stills;
  stills.transparent = options.output.transparent;
  if (options.output.is_picture()) stills.poster_file = options.output.file;
  if (!stills.poster && (options.output.is_picture() || options.output.watch)) {
    stills.poster = duration / 2;
  }
  return stills;
}

int render(const Common& common, const Options& asked) {
  Options options = asked;
  check_outputs(options.output, options.inputs.several(),
                options.no_video || options.stills.poster || options.output.watch);
  const Backend backend = backend_named(options.backend);
  Scene scene = load_chosen(options.scene, true, options.method);
  const int planned_height = scene.height;
  const Preset preset = preset_of(options.output.preset, scene.width, scene.height, 4);
  std::tie(scene.width, scene.height) = std::pair(preset.width, preset.height);
  if (options.samples == 0) options.samples = preset.samples;
  if (!options.size.empty()) std::tie(scene.width, scene.height) = picture_size(options.size);
  const auto complete = [&] {
    const Needs needs =
        scene.stage ? clip_needs(scene, 0, options.samples) : simulation_needs(scene);
    refuse_beyond({.memory = needs.memory}, scene, options.max_memory, "", kFewer, true);
    complete_stage(scene, chosen_changes(options.method), stop_if_interrupted);
  };
  if (options.method.planned) {
    complete();
    enlarge(scene, double(scene.height) / planned_height, options.samples);
  }
  const int fps = options.fps > 0 ? options.fps : scene.fps;
  const std::string proof = proof_of(scene, options, fps);
  scene.fps = fps;
  scene.method = chosen_method(options.method, scene);
  if (!options.method.planned) complete();
  options.stills = stills_of(options, clip_length(scene) / scene.fps);
  const bool video = !options.no_video && !options.stills.any();
  const std::string ending = options.output.file.empty()
                                 ? ".mp4"
                                 : std::filesystem::path(options.output.file).extension().string();
  if (video && needs_even_sides(ending) && (scene.width % 2 || scene.height % 2))
    throw Misuse(
        fmt::format("a video of {}x{} is not possible: {} (yuv420p) needs even sides "
                    "(--no-video makes frames of any size)",
                    scene.width, scene.height, ending == ".mp4" ? "H.264" : ending));
  refuse_beyond({.memory = clip_needs(scene, 0, options.samples).memory}, scene, options.max_memory,
                "", kFewer, true);
  const std::vector<ClipFrame> clip = clip_frames(scene);
  const std::vector<int> frames = frame_list(options.frames, int(clip.size()));
  if (video) require_ffmpeg();

  const std::string name = scene_name(options.scene);
  const std::filesystem::path out =
      results_folder(options.scene, options.out, options.inputs.several());
  const Provenance provenance(scene, options.scene);
  if (!options.stills.any()) {
    Needs needs = clip_needs(scene, double(frames.size()), options.samples);
    needs.disk *= double(missing_frames(out / "frames", frames)) / double(frames.size());
    refuse_beyond(needs, scene, options.max_memory, out, kFewer, common.quiet);
  }
  const bool one_by_one = options.profile || options.stills.any();
  RenderWorkers workers(backend, common.threads, one_by_one, scene, scene.width, scene.height,
                        options.samples);
  if (options.stills.any()) {
    write_output(make_stills(options.stills, scene, workers.film(), out, provenance));
    return kDone;
  }
  Font font;
  FrameFolder folder(out / "frames", !options.anew, {scene.width, scene.height});
  Profile profile, unlit;
  Profile* const measured = options.profile ? &profile : nullptr;
  workers.film().set_profile(measured);
  std::optional<Film> unlit_film;
  if (measured) {
    unlit_film.emplace(workers.context(), scene, scene.width, scene.height, options.samples,
                       Shading{.lit = false});
    unlit_film->set_profile(&unlit);
  }
  double unlit_time = 0;

  SelfEstimate estimate(scene, !options.no_estimate);
  double estimate_time = 0;
  const auto simulation_start = Clock::now();
  const auto states =
      record(scene, clip, frames, stop_if_interrupted, [&](const Simulation& simulation) {
        const auto start = Clock::now();
        estimate.follow(simulation);
        estimate_time += seconds_since(start);
      });
  const double simulation_time = seconds_since(simulation_start) - estimate_time;

  const std::uint64_t shared = Hash()
                                   .number(program_fingerprint())
                                   .number(fingerprint(*scene.stage))
                                   .text(workers.context().description())
                                   .number(scene.width)
                                   .number(scene.height)
                                   .number(options.samples)
                                   .text(options.certificate ? proof : "")
                                   .text(provenance.text())
                                   .number(options.output.transparent)
                                   .value();
  std::size_t drawn = 0, drawn_again = 0, exposures = 0;
  const auto rendering_start = Clock::now();
  {
    Progress progress("rendering", "frames", frames.size(), common.quiet);
    std::mutex mutex;  // of everything that counts, and of the font
    std::size_t done = 0;
    workers.each(frames.size(), [&](Film& film, std::size_t i) {
      stop_if_interrupted();
      film.set_transparent(options.output.transparent);
      if (measured) profile.start();
      const ClipFrame& frame = clip[std::size_t(frames[i])];
      const std::vector<Instant> shutter = film.shutter(frame, states[i]);
      if (measured) profile.lap("pose");
      const std::uint64_t inputs =
          Hash().number(shared).number(fingerprint(shutter)).number(frame.card_shown).value();
      const bool is_there = folder.has(frames[i], inputs);
      Film::Frame made{};
      if (!is_there) made = film.draw(frame, shutter);
      const std::lock_guard lock(mutex);
      if (!is_there) {
        drawn_again += folder.knows(frames[i]);
        if (options.certificate) draw_note(made.picture, font, "Certificate: " + proof);
        folder.put(frames[i], inputs, std::move(made.picture),
                   provenance.picture(frame.time, options.output.transparent));
        exposures += std::size_t(made.exposures);
        ++drawn;
        if (measured) {  // alone, so that its time is not another stage's
          folder.finish();
          profile.lap("PNG");
          const auto start = Clock::now();
          unlit.start();
          unlit_film->draw(frame, shutter);
          unlit_time += seconds_since(start);
        }
      }
      progress.update(++done);
    });
    folder.finish();
  }
  const double rendering_time = seconds_since(rendering_start) - unlit_time;
  if (!common.quiet && (drawn_again > 0 || drawn < frames.size()))
    note("{} of {} frames were there already{}\n", frames.size() - drawn, frames.size(),
         drawn_again > 0 ? fmt::format("; {} were made from another scene, program, driver or "
                                       "other options, and are drawn again",
                                       drawn_again)
                         : "");
  // Where something moves, a pixel of a frame has a sample for each exposure.
  const double mean_exposures = drawn ? double(exposures) / double(drawn) : 0;

  nlohmann::ordered_json report = {
      {"scene", options.scene},
      {"title", scene.title},
      {"method",
       {{"name", scene.method.name}, {"settings", settings_json(full_settings(scene.method))}}},
      {"size_px", {scene.width, scene.height}},
      {"fps", scene.fps},
      {"samples", options.samples},
      {"version", version()},
      {"renderer", workers.context().description()},
      {"frames", frames.size()},
      {"frames_drawn", drawn},
      {"mean_exposures", mean_exposures},
      {"frames_folder", (out / "frames").string()},
      {"seconds_per_frame",
       {{"simulation", simulation_time / double(frames.back() + 1)},
        {"rendering", drawn ? rendering_time / double(drawn) : 0.0}}}};
  const bool proven = options.method.planned || options.certificate;
  if (proven) report["certificate"] = proof;
  estimate.add_to(report);
  if (video) {
    std::vector<std::filesystem::path> files;
    for (const int frame : frames) files.push_back(folder.file(frame));
    const std::filesystem::path file = options.output.file.empty()
                                           ? out / (name + ".mp4")
                                           : std::filesystem::path(options.output.file);
    const auto encoding_start = Clock::now();
    const Encoding encoding{options.output.quality, options.output.transparent, provenance.video()};
    encode_video(files, scene.fps, file, encoding,
                 std::chrono::milliseconds(std::llround(1e3 * options.patience)));
    report["seconds_per_frame"]["encoding"] = seconds_since(encoding_start) / double(frames.size());
    report["video"] = file.string();
  }
  std::optional<StageFloor> floor;
  if (measured) {
    floor.emplace(scene.width, scene.height, options.samples);
    report["profile"] = stage_json(profile, unlit, *floor);
  }
  if (!common.quiet && proven) note("certificate: {}\n", proof);
  if (!common.quiet) note("{}", estimate.line());
  const std::string text = report.dump(2) + "\n";
  AtomicFile record_file(out / "clip.json");
  record_file.write(text);
  record_file.commit();
  if (common.json) {
    write_output(text);
  } else {
    write_output((video ? report["video"] : report["frames_folder"]).get<std::string>() + "\n");
    if (measured)
      write_output(fmt::format("{}exposures per frame: {:.2f}\n",
                               table_text(stage_table(profile, unlit, *floor, drawn)),
                               mean_exposures));
  }
  return kDone;
}

/// The files that a scene is written in.
std::vector<std::filesystem::path> files_of(const std::string& scene) {
  std::vector<std::filesystem::path> files = {scene};
  try {
    const std::filesystem::path base = read_document(scene).base;
    if (!base.empty()) files.push_back(base);
  } catch (const BadScene&) {  // which is told when it is read to be rendered
  }
  return files;
}

int render_or_watch(const Common& common, const Options& options) {
  if (!options.output.watch) return render(common, options);
  if (options.scene == "-" || options.inputs.several()) {
    throw Misuse("--watch: expected one scene file");
  }
  return watch(files_of(options.scene), common, [&] { return render(common, options); });
}

}  // namespace

void add_render(CLI::App& app, Program& program) {
  CLI::App& command =
      add_command(app, program, "render", "Render a scene's clip",
                  "  taut render scenes/nunchaku.toml\n"
                  "  taut render scenes/nunchaku.toml -o nunchaku.webp --preset draft\n"
                  "  taut render scenes/rope_swing.toml --set connectors.rope.length=0.3 --watch\n"
                  "  taut render scenes/nunchaku.toml --frames 0-59,120 --size 960x540 --no-video\n"
                  "  taut render scenes/nunchaku.toml --resume\n\n" +
                      std::string(kEstimateHelp) +
                      "\nclip.json has it: error_estimate_m, predictable_until_s, "
                      "estimate_ms_per_second.");
  auto options = std::make_shared<Options>();
  add_scene_options(command, options->inputs, false);
  command.add_option("--out", options->out,
                     "The clip's folder; default: below out/, by the scene's path");
  add_output_options(command, options->output);
  command.add_option("--frames", options->frames, "Frames to make, as A-B,C; default all");
  command.add_option("--size", options->size, "WxH in pixels; default the scene's");
  command.add_option("--fps", options->fps, "Frames per second; default the scene's")
      ->check(CLI::Range(1, 1000));
  command
      .add_option("--samples", options->samples, "Samples per pixel; default: the preset's, or 4")
      ->check(CLI::Range(1, 64));
  add_method_options(command, options->method);
  command.add_flag("--no-estimate", options->no_estimate, "No estimate of the run's own error");
  add_memory_option(command, options->max_memory);
  command.add_flag("--certificate", options->certificate,
                   "A line on the picture says what is proved of the clip, or that nothing is");
  command.add_option("--backend", options->backend, "auto, egl or osmesa")
      ->check(CLI::IsMember({"auto", "egl", "osmesa"}));
  command.add_flag("--resume", options->resume,
                   "Keep finished frames that would come out the same: the default");
  command.add_flag("--anew", options->anew, "Draw every frame, also those that are there")
      ->excludes("--resume");
  command.add_flag("--contact-sheet", options->stills.contact_sheet,
                   "Only a sheet of the captions' middles, contact_sheet.png");
  command
      .add_option("--every", options->stills.every,
                  "The sheet shows the clip at every so many seconds instead")
      ->check(CLI::PositiveNumber);
  command.add_option("--poster", options->stills.poster,
                     "Only the picture at this time of the clip (s), poster.png");
  command.add_flag("--profile", options->profile,
                   "Time a frame's stages, one after another, and print their medians beside what "
                   "they cannot take less than");
  command.add_flag("--no-video", options->no_video, "Frames only");
  command
      .add_option("--patience", options->patience,
                  "Seconds after which an FFmpeg that does nothing is given up; default 60")
      ->check(CLI::PositiveNumber);
  command.callback([&program, options] {
    program.run = [&program, options] {
      return for_each_scene(options->inputs, program.common, [&](const std::string& scene) {
        Options one = *options;
        one.scene = scene;
        return render_or_watch(program.common, one);
      });
    };
  });
}

}  // namespace taut::cli
