#include "render/clip/clip_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/base/version.h"
#include "render/film/fingerprint.h"
#include "render/film/video.h"
#include "render/options/needs.h"
#include "render/options/scene_options.h"
#include "render/program/frame_list.h"
#include "render/program/json.h"
#include "render/program/note.h"
#include "sim/motion/hash.h"

namespace taut::clips {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The proof of the clip at `fps` frames a second.
std::string proof_of(const scenes::Scene& scene, const RenderOptions& options, int fps) {
  if (!options.method.planned) return "none: the clip is not by a plan (--planned)";
  if (fps != scene.fps) {
    return fmt::format("none: the plan is of {} frames a second, the clip of {}", scene.fps, fps);
  }
  return scenes::certificate(*scene.plan);
}

/// The plan's pixels are those of a picture as high as the scene's; of another they are as many
/// more.
void enlarge(scenes::Scene& scene, double times, int samples) {
  scenes::Plan& plan = *scene.plan;
  if (!plan.tolerance.ends_with("px")) return;
  plan.error *= times;
  if (plan.exposures == 0) return;
  scene.stage->exposures_apart *= times;
  if (plan.exposures > 1) scene.stage->exposures = std::max(scene.stage->exposures, samples);
}

/// Frames that are to be made and are no files yet.
std::size_t missing_frames(const fs::path& folder, const std::vector<int>& frames) {
  std::error_code error;
  return std::size_t(std::ranges::count_if(frames, [&](int frame) {
    return !fs::exists(folder / fmt::format("{:06}.png", frame), error);
  }));
}

std::chrono::milliseconds patience_of(const RenderOptions& options) {
  return std::chrono::milliseconds(std::llround(1e3 * options.patience));
}

constexpr int kPreviewRate = 24;  // frames a second, at most

constexpr const char* kFewer = ", fewer frames at a time (--frames), smaller pictures (--size)";

/// Scenery fills a picture, and would leave nothing of it transparent.
void leave_out_scenery(options::MethodOptions& chosen) {
  const auto is_scenery = [](const std::string& set) { return set.starts_with("stage.scenery"); };
  if (std::ranges::none_of(chosen.set, is_scenery)) chosen.set.emplace_back("stage.scenery=[]");
}

/// The options of a single picture, where one is asked for in whatever way.
Stills stills_of(const RenderOptions& options, double duration) {
  Stills stills = options.stills;
  stills.transparent = options.output.transparent;
  if (options.output.is_picture()) stills.poster_file = options.output.file;
  if (!stills.poster && (options.output.is_picture() || options.output.watch)) {
    stills.poster = duration / 2;
  }
  return stills;
}

std::string ending_of(const RenderOptions& options) {
  return options.output.file.empty() ? ".mp4" : fs::path(options.output.file).extension().string();
}

/// Throws Misuse where options make no sense together.
void check_options(const RenderOptions& options) {
  options::check_outputs(options.output, options.inputs.several(),
                         options.no_video || options.stills.poster || options.output.watch);
  const bool one_picture =
      options.stills.any() || options.output.is_picture() || options.output.watch;
  if ((options.part.is_part() || options.part.merge) && one_picture) {
    throw program::Misuse("--part and --merge: a single picture has no parts");
  }
}

}  // namespace

ClipJob::ClipJob(const RenderOptions& asked, const program::Common& common) : options(asked) {
  check_options(options);
  if (options.output.transparent && !options.method.planned) leave_out_scenery(options.method);
  backend = gl::backend_named(options.backend);
  scene = options::load_chosen(options.scene, true, options.method);
  const int planned_height = scene.height;
  const options::Preset preset = options::preset_of(options.output, scene.width, scene.height, 4);
  std::tie(scene.width, scene.height) = std::pair(preset.width, preset.height);
  if (options.samples == 0) options.samples = preset.samples;
  if (!options.size.empty())
    std::tie(scene.width, scene.height) = program::picture_size(options.size);
  const auto complete = [&] {
    const options::Needs needs =
        scene.stage ? options::clip_needs(scene, 0, options.samples, common.threads)
                    : options::simulation_needs(scene);
    options::refuse_beyond({.memory = needs.memory}, scene, options.max_memory, "", kFewer, true);
    options::complete_stage(scene, options::chosen_changes(options.method), common);
  };
  if (options.method.planned) {
    complete();
    enlarge(scene, double(scene.height) / planned_height, options.samples);
  }
  const int most = options.output.preview ? std::min(scene.fps, kPreviewRate) : scene.fps;
  const int fps = options.fps > 0 ? options.fps : most;
  proof = proof_of(scene, options, fps);
  scene.fps = fps;
  scene.method = options::chosen_method(options.method, scene);
  if (!options.method.planned) complete();
  options::tell_left_out(scene, common);
  if (options.output.preview) {
    scene.stage->shutter = 0;
    options.no_estimate = true;
  }
  options.stills = stills_of(options, options::clip_length(scene) / scene.fps);
  video = !options.no_video && !options.stills.any();
  const std::string ending = ending_of(options);
  if (video && film::needs_even_sides(ending) && (scene.width % 2 || scene.height % 2))
    throw program::Misuse(
        fmt::format("a video of {}x{} is not possible: {} (yuv420p) needs even sides "
                    "(--no-video makes frames of any size)",
                    scene.width, scene.height, ending == ".mp4" ? "H.264" : ending));
  options::refuse_beyond(
      {.memory = options::clip_needs(scene, 0, options.samples, common.threads).memory}, scene,
      options.max_memory, "", kFewer, true);
  clip = scenes::clip_frames(scene);
  frames = program::frame_list(options.frames, int(clip.size()));
  out = options::results_folder(options.scene, options.out, options.inputs.several());
  if (options.output.preview) out /= "preview";
  frame_path = out / "frames";
  if (options.part.is_part()) {
    video = false;
    frame_path = program::part_path(out, kParts, options.part).path;
    std::vector<int> own;
    for (const std::size_t i :
         program::pieces_of(options.part, frames.size(), program::Share::neighbours)) {
      own.push_back(frames[i]);
    }
    frames = std::move(own);
  }
  if (video) film::require_ffmpeg(patience_of(options));
  if (options.stills.any() || options.part.merge || frames.empty()) return;
  options::Needs needs =
      options::clip_needs(scene, double(frames.size()), options.samples, common.threads);
  needs.disk *= double(missing_frames(frame_path, frames)) / double(frames.size());
  options::refuse_beyond(needs, scene, options.max_memory, out, kFewer, common.quiet);
}

std::uint64_t ClipJob::fingerprint(const std::string& renderer) const {
  return Hash()
      .number(film::program_fingerprint())
      .number(film::fingerprint(*scene.stage))
      .text(renderer)
      .number(scene.width)
      .number(scene.height)
      .number(options.samples)
      .text(options.certificate ? proof : "")
      .text(provenance().text())
      .number(options.output.transparent)
      .value();
}

std::uint64_t frame_inputs(std::uint64_t job, const scenes::ClipFrame& frame,
                           const std::vector<draw::FrameState>& shutter) {
  const scenes::Shot& shot = *frame.shot;  // what captions it shows depends on where it is cut
  return Hash()
      .number(job)
      .number(film::fingerprint(shutter))
      .number(shot.from)
      .number(shot.until)
      .number(shot.rate)
      .number(frame.card_shown)
      .value();
}

ClipStates::ClipStates(const ClipJob& job, studies::SelfEstimate& estimate)
    : simulation_(job.scene, job.clip, job.frames, render::stop_if_interrupted,
                  [this, &estimate](const Simulation& simulation) {
                    const auto begin = Clock::now();
                    estimate.follow(simulation);
                    estimate_time_ += seconds_since(begin);
                  }) {}

scenes::ClipSimulation::Shutter ClipStates::next() {
  const double before = estimate_time_;
  const auto begin = Clock::now();
  scenes::ClipSimulation::Shutter shutter = simulation_.next();
  time_ += seconds_since(begin) - (estimate_time_ - before);
  return shutter;
}

nlohmann::ordered_json clip_report(const ClipJob& job, const FramesMade& made) {
  const scenes::Scene& scene = job.scene;
  nlohmann::ordered_json report = {
      {"scene", job.options.scene},
      {"title", scene.title},
      {"method",
       {{"name", scene.method.name},
        {"settings", options::settings_json(with_defaults(scene.method))}}},
      {"size_px", {scene.width, scene.height}},
      {"fps", scene.fps},
      {"samples", job.options.samples},
      {"version", render::version()},
      {"renderer", made.renderer},
      {"frames", job.frames.size()},
      {"frames_drawn", made.drawn},
      {"mean_exposures", made.mean_exposures()},
      {"frames_folder", job.frame_path.string()},
      {"seconds_per_frame",
       {{"simulation", job.frames.empty() ? 0.0 : made.simulating / double(job.frames.back() + 1)},
        {"rendering", made.drawn ? made.drawing / double(made.drawn) : 0.0}}}};
  if (job.options.method.planned || job.options.certificate) report["certificate"] = job.proof;
  return report;
}

void finish_clip(const ClipJob& job, nlohmann::ordered_json& report,
                 const studies::SelfEstimate& estimate, const program::Common& common) {
  estimate.add_to(report);
  const RenderOptions& options = job.options;
  if (job.video) {
    std::vector<fs::path> files;
    for (const int frame : job.frames)
      files.push_back(film::FrameFolder::file(job.frame_path, frame));
    const fs::path file = options.output.file.empty()
                              ? job.out / (options::scene_name(options.scene) + ".mp4")
                              : fs::path(options.output.file);
    const auto start = Clock::now();
    const film::Encoding encoding{options.output.quality, options.output.transparent,
                                  job.provenance().video()};
    film::encode_video(files, job.scene.fps, file, encoding, patience_of(options));
    report["seconds_per_frame"]["encoding"] = seconds_since(start) / double(job.frames.size());
    report["video"] = file.string();
  }
  if (!common.quiet && report.contains("certificate"))
    program::note("certificate: {}\n", job.proof);
  if (!common.quiet) program::note("{}", program::Lines{estimate.line()});
  render::AtomicFile file((options.part.is_part() ? job.frame_path : job.out) / kRecord);
  file.write(program::json_text(report) + "\n");
  file.commit();
}

std::string result_text(const nlohmann::ordered_json& report, const program::Common& common) {
  if (common.json) return program::json_text(report) + "\n";
  return report[report.contains("video") ? "video" : "frames_folder"].get<std::string>() + "\n";
}

}  // namespace taut::clips
