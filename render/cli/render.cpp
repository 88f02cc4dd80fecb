// taut render: a scene's clip.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "render/atomic_file.h"
#include "render/caption.h"
#include "render/cli/clip_job.h"
#include "render/cli/command.h"
#include "render/cli/needs.h"
#include "render/cli/note.h"
#include "render/cli/profile_report.h"
#include "render/cli/progress.h"
#include "render/cli/terminal.h"
#include "render/cli/watch.h"
#include "render/interrupt.h"
#include "render/profile.h"
#include "render/render_workers.h"
#include "render/stage_floor.h"
#include "render/table.h"
#include "scenes/error.h"
#include "scenes/reader/document.h"

namespace taut::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// Draws frames of a job with --profile: stage by stage, and each once more without light.
class Profiled {
 public:
  Profiled(const ClipJob& job, RenderWorkers& workers)
      : job_(job),
        film_(workers.context(), job.scene, job.scene.width, job.scene.height, job.options.samples,
              Shading{.lit = false}) {
    workers.film().set_profile(&lit_);
    film_.set_profile(&unlit_);
  }

  void start() { lit_.start(); }
  void lap(const char* stage) { lit_.lap(stage); }
  void draw_unlit(const ClipFrame& frame, std::span<const Instant> shutter) {
    const auto start = Clock::now();
    unlit_.start();
    film_.draw(frame, shutter);
    time_ += std::chrono::duration<double>(Clock::now() - start).count();
  }
  /// Of drawing without light, s.
  double time() const { return time_; }

  void measure_floor() {
    floor_.emplace(job_.scene.width, job_.scene.height, job_.options.samples);
  }
  nlohmann::ordered_json json() const { return stage_json(lit_, unlit_, *floor_); }
  std::string table(std::size_t drawn) const {
    return table_text(stage_table(lit_, unlit_, *floor_, drawn));
  }

 private:
  const ClipJob& job_;
  Film film_;
  Profile lit_, unlit_;
  std::optional<StageFloor> floor_;
  double time_ = 0;
};

/// Draws the frames that are not there yet.
FramesMade draw_frames(const ClipJob& job, const ClipStates& states, RenderWorkers& workers,
                       FrameFolder& folder, Profiled* profiled, const Common& common) {
  FramesMade made;
  made.renderer = workers.context().description();
  const std::uint64_t shared = job.fingerprint(made.renderer);
  const Provenance provenance = job.provenance();
  const bool transparent = job.options.output.transparent;
  Font font;
  const auto begin = Clock::now();
  Progress progress("rendering", "frames", job.frames.size(), common.quiet);
  std::mutex mutex;  // of everything that counts, and of the font
  std::size_t done = 0;
  workers.each(job.frames.size(), [&](Film& film, std::size_t i) {
    stop_if_interrupted();
    film.set_transparent(transparent);
    if (profiled) profiled->start();
    const int number = job.frames[i];
    const ClipFrame& frame = job.clip[std::size_t(number)];
    const std::vector<Instant> shutter = film.shutter(frame, states.of_frames[i]);
    if (profiled) profiled->lap("pose");
    const std::uint64_t inputs = frame_inputs(shared, frame, shutter);
    const bool is_there = folder.has(number, inputs);
    Film::Frame drawn{};
    if (!is_there) drawn = film.draw(frame, shutter);
    const std::lock_guard lock(mutex);
    if (!is_there) {
      made.drawn_again += folder.knows(number);
      if (job.options.certificate) draw_note(drawn.picture, font, "Certificate: " + job.proof);
      folder.put(number, inputs, std::move(drawn.picture),
                 provenance.picture(frame.time, transparent));
      made.exposures += double(drawn.exposures);
      ++made.drawn;
      if (profiled) {  // alone, so that its time is not another stage's
        folder.finish();
        profiled->lap("PNG");
        profiled->draw_unlit(frame, shutter);
      }
    }
    progress.update(++done);
  });
  folder.finish();
  made.time = std::chrono::duration<double>(Clock::now() - begin).count() -
              (profiled ? profiled->time() : 0);
  return made;
}

int draw_clip(const ClipJob& job, const Common& common) {
  const RenderOptions& options = job.options;
  const bool one_by_one = options.profile || options.stills.any();
  RenderWorkers workers(job.backend, common.threads, one_by_one, job.scene, job.scene.width,
                        job.scene.height, options.samples);
  if (options.stills.any()) {
    write_output(make_stills(options.stills, job.scene, workers.film(), job.out, job.provenance()));
    return kDone;
  }
  FrameFolder folder(job.frame_path, !options.anew, job.size());
  std::optional<Profiled> profiled;
  if (options.profile) profiled.emplace(job, workers);
  SelfEstimate estimate(job.scene, !options.no_estimate && !options.part.is_part());
  const ClipStates states = record_states(job, estimate);
  const FramesMade made =
      draw_frames(job, states, workers, folder, profiled ? &*profiled : nullptr, common);
  if (!common.quiet && (made.drawn_again > 0 || made.drawn < job.frames.size()))
    note("{} of {} frames were there already{}\n", job.frames.size() - made.drawn,
         job.frames.size(),
         made.drawn_again > 0 ? fmt::format("; {} were made from another scene, program, driver or "
                                            "other options, and are drawn again",
                                            made.drawn_again)
                              : "");
  nlohmann::ordered_json report = clip_report(job, states, made);
  if (profiled) {
    profiled->measure_floor();
    report["profile"] = profiled->json();
  }
  finish_clip(job, report, estimate, common);
  if (options.part.is_part()) {
    return say_part_done(options.part, job.frame_path, job.frames.size(), common);
  }
  write_output(result_text(report, common));
  if (profiled && !common.json)  // where something moves, a sample for each exposure
    write_output(fmt::format("{}exposures per frame: {:.2f}\n", profiled->table(made.drawn),
                             made.mean_exposures()));
  return kDone;
}

int render(const Common& common, const RenderOptions& options) {
  const ClipJob job(options, common);
  if (options.part.merge) return merge_clip(job, common);
  if (options.part.is_part() && job.frames.empty()) {  // there are more parts than frames
    return say_part_done(options.part, job.frame_path, 0, common);
  }
  return draw_clip(job, common);
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

int render_or_watch(const Common& common, const RenderOptions& options) {
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
  auto options = std::make_shared<RenderOptions>();
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
  add_part_options(command, options->part, "frames");
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
        RenderOptions one = *options;
        one.scene = scene;
        return render_or_watch(program.common, one);
      });
    };
  });
}

}  // namespace taut::cli
