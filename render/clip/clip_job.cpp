#include "render/clip/clip_job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>
#include <tuple>
#include <vector>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/base/version.h"
#include "render/chart/table.h"
#include "render/draw/stage_renderer.h"
#include "render/film/caption.h"
#include "render/film/film.h"
#include "render/film/frame_folder.h"
#include "render/film/render_workers.h"
#include "render/film/video.h"
#include "render/gl/gpu.h"
#include "render/options/method_options.h"
#include "render/options/needs.h"
#include "render/options/scene_options.h"
#include "render/picture/text.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "scenes/files/files.h"
#include "scenes/scene/clip.h"
#include "sim/motion/hash.h"

namespace taut::clips {
namespace {

constexpr std::string_view kPicture = ".png";

std::string ending_of(const std::string& file) {
  return std::filesystem::path(file).extension().string();
}

/// The nearest even number of pixels, of a side that follows another.
int even(double side) {
  return std::max(2, 2 * static_cast<int>(std::lround(side / 2)));
}

}  // namespace

bool OutputOptions::is_picture() const {
  return ending_of(file) == kPicture;
}

void add_output_options(program::Command& command, OutputOptions& options) {
  command
      .add_option("-o,--output", options.file,
                  "Output file: .mp4, .webm, .mov (ProRes 4444), .gif, .webp or .apng; .png is one "
                  "picture, of the clip's middle or of --poster")
      .type_name("FILE");
  command.add_option("--quality", options.quality, "Quality of the video, 0 to 100; default 85")
      .range(0, 100);
  command.add_flag(
      "--transparent", options.transparent,
      "Transparent instead of background and scenery: frames, .png, .webm, .mov, .webp, .apng");
  command
      .add_option("--preset", options.preset,
                  "draft: 640 pixels wide, 1 sample per pixel; final: the scene's size, 8 samples, "
                  "in several passes if the driver has fewer; 4k: 3840 wide")
      .one_of({"draft", "final", "4k"});
  command.add_flag("--preview", options.preview,
                   "Quick look: 480 pixels wide, 1 sharp sample per pixel, at most 24 frames a "
                   "second, no estimate, in a folder of its own, preview");
  command.add_flag(
      "--watch", options.watch,
      "Draw a poster whenever the scene or a file that it names is saved, until Ctrl-C");
}

void check_outputs(const OutputOptions& options, bool several, bool frames_alone) {
  const std::string ending = ending_of(options.file);
  if (!options.file.empty() && several) {
    throw program::Misuse(
        fmt::format("-o {}: one file for several scenes, expected --out FOLDER", options.file));
  }
  const auto known = film::video_endings();
  if (!options.file.empty() && ending != kPicture &&
      std::ranges::find(known, ending) == known.end()) {
    throw program::Misuse(fmt::format("-o {}: expected a name that ends with {} or {}",
                                      options.file, fmt::join(known, ", "), kPicture));
  }
  const bool opacity =
      options.file.empty() ? frames_alone : ending == kPicture || film::keeps_opacity(ending);
  if (options.transparent && !opacity) {
    throw program::Misuse(fmt::format(
        "--transparent: {} keeps no opacity; expected -o with .png, .webm, .mov, .webp or .apng, "
        "or --no-video",
        options.file.empty() ? "an .mp4" : options.file));
  }
}

Preset preset_of(const OutputOptions& options, int width, int height, int samples) {
  const double aspect = static_cast<double>(height) / width;
  if (options.preview) return {480, even(480 * aspect), 1};
  const std::string& name = options.preset;
  if (name == "draft") return {640, even(640 * aspect), 1};
  if (name == "final") return {width, height, 8};
  if (name == "4k") return {3840, even(3840 * aspect), samples};
  return {width, height, samples};
}

Provenance::Provenance(const scenes::Scene& scene, const std::string& file)
    : title_(scene.title),
      scene_(file),
      method_(fmt::format("{} ({})", scene.method.name,
                          options::settings_text(with_defaults(scene.method)))) {}

picture::PngExtras Provenance::picture(double time, bool opacity) const {
  return {opacity,
          {{"Title", title_},
           {"Software", fmt::format("taut {}", render::version())},
           {"Source", scene_},
           {"taut:time", fmt::format("{:.6g} s", time)},
           {"taut:method", method_}}};
}

std::vector<std::pair<std::string, std::string>> Provenance::video() const {
  return {{"title", title_}, {"comment", text()}};
}

std::string Provenance::text() const {
  return fmt::format("taut {}, scene {}, method {}", render::version(), scene_, method_);
}

chart::Table stage_table(const gl::Profile& profile, const gl::Profile& unlit,
                         const draw::StageFloor& floor, std::size_t drawn) {
  chart::Table table{{"stage", "wall ms", "CPU ms", "floor ms", "% of frames"}, {}};
  gl::Profile::Times sum;
  for (const gl::Profile::Stage& stage : profile.stages()) {
    const auto [cpu, wall] = gl::median(stage);
    const double share =
        std::min(double(stage.frames.size()) / double(std::max<std::size_t>(drawn, 1)), 1.0);
    const std::optional<double> least = floor.of(stage.name, unlit);
    table.add({stage.name, fmt::format("{:.2f}", 1e3 * wall), fmt::format("{:.2f}", 1e3 * cpu),
               least ? fmt::format("{:.2f}", 1e3 * *least) : "",
               fmt::format("{:.0f}", 100 * share)});
    sum.cpu += share * cpu;
    sum.wall += share * wall;
  }
  table.add({"one after another", fmt::format("{:.2f}", 1e3 * sum.wall),
             fmt::format("{:.2f}", 1e3 * sum.cpu), "", ""});
  return table;
}

nlohmann::ordered_json stage_json(const gl::Profile& profile, const gl::Profile& unlit,
                                  const draw::StageFloor& floor) {
  auto stages = nlohmann::ordered_json::array();
  for (const gl::Profile::Stage& stage : profile.stages()) {
    const auto [cpu, wall] = gl::median(stage);
    stages.push_back(
        {{"stage", stage.name}, {"wall", wall}, {"cpu", cpu}, {"frames", stage.frames.size()}});
    if (const auto least = floor.of(stage.name, unlit)) stages.back()["floor"] = *least;
  }
  return stages;
}

namespace {

void write_png(const std::filesystem::path& name, const picture::Picture& picture,
               const picture::PngExtras& extras) {
  const auto bytes = picture::encode_png(picture, extras);
  render::AtomicFile file(name);
  file.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  file.commit();
}

/// The frame that shows a time of the scene best: of those within a frame of it the slowest shot's,
/// of these the nearest. None under a card.
int frame_at(const std::vector<scenes::ClipFrame>& frames, double time, int fps) {
  const auto worth = [&](const scenes::ClipFrame& f) {
    const double off = f.card ? 1e300 : std::abs(f.time - time);
    return std::tuple(off > 1.0 / fps ? off : 0, f.rate, off);
  };
  return int(std::ranges::min_element(frames, {}, worth) - frames.begin());
}

/// The frames of a contact sheet, and how many stand in a row.
std::pair<std::vector<int>, int> on_sheet(const Stills& stills, const scenes::Scene& scene,
                                          const std::vector<scenes::ClipFrame>& frames) {
  std::vector<int> chosen;
  if (!stills.every) {
    for (const scenes::Caption& caption : scene.stage->captions)
      chosen.push_back(frame_at(frames, (caption.from + caption.until) / 2, scene.fps));
    std::ranges::sort(chosen);
    if (chosen.empty()) throw program::Misuse("--contact-sheet: the scene has no captions to show");
    return {chosen, 3};
  }
  for (int i = 0;; ++i) {
    const auto frame = std::lround(i * *stills.every * scene.fps);
    if (frame >= std::ssize(frames)) break;
    chosen.push_back(int(frame));
  }
  return {chosen, int(std::ceil(std::sqrt(double(chosen.size()))))};
}

}  // namespace

std::string make_stills(const Stills& stills, const scenes::Scene& scene, film::Film& film,
                        const std::filesystem::path& out, const Provenance& provenance) {
  const std::vector<scenes::ClipFrame> frames = scenes::clip_frames(scene);
  const auto draw_all = [&](const std::vector<int>& wanted, int shrink) {
    const auto open = scenes::record(scene, frames, wanted, render::stop_if_interrupted);
    std::vector<picture::Picture> pictures;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      render::stop_if_interrupted();
      const scenes::ClipFrame& frame = frames[std::size_t(wanted[i])];
      picture::Picture drawn = film.draw(frame, film.shutter(frame, open[i])).picture;
      pictures.push_back(shrink > 1 ? picture::shrunk(drawn, shrink) : std::move(drawn));
    }
    return pictures;
  };
  std::string made;
  if (stills.contact_sheet || stills.every) {
    const auto [wanted, columns] = on_sheet(stills, scene, frames);
    write_png(out / "contact_sheet.png", film::contact_sheet(draw_all(wanted, columns), columns),
              provenance.picture(frames[std::size_t(wanted.front())].time, false));
    made += (out / "contact_sheet.png").string() + "\n";
  }
  if (stills.poster) {
    const double end = double(frames.size()) / scene.fps;
    if (!(*stills.poster >= 0 && *stills.poster <= end)) {
      throw program::Misuse(
          fmt::format("--poster {}: the clip lasts from 0 to {:g} s", *stills.poster, end));
    }
    const int frame =
        std::min(int(std::lround(*stills.poster * scene.fps)), int(frames.size()) - 1);
    const std::filesystem::path file =
        stills.poster_file.empty() ? out / "poster.png" : std::filesystem::path(stills.poster_file);
    film.set_transparent(stills.transparent);
    write_png(file, draw_all({frame}, 1)[0],
              provenance.picture(frames[std::size_t(frame)].time, stills.transparent));
    made += file.string() + "\n";
  }
  return made;
}

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
  check_outputs(options.output, options.inputs.several(),
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
  const Preset preset = preset_of(options.output, scene.width, scene.height, 4);
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
  scenes::settle_breaks(scene);
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

// The frames of a clip, drawn.

namespace {

using Clock = std::chrono::steady_clock;

/// Draws frames of a job with --profile: stage by stage, and each once more without light.
class Profiled {
 public:
  Profiled(const ClipJob& job, film::RenderWorkers& workers)
      : job_(job),
        film_(workers.context(), job.scene, job.scene.width, job.scene.height, job.options.samples,
              draw::Shading{.lit = false}) {
    workers.film().set_profile(&lit_);
    film_.set_profile(&unlit_);
  }

  void start() { lit_.start(); }
  void lap(const char* stage) { lit_.lap(stage); }
  void draw_unlit(const scenes::ClipFrame& frame, std::span<const draw::FrameState> shutter) {
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
    return program::table_text(stage_table(lit_, unlit_, *floor_, drawn));
  }

 private:
  const ClipJob& job_;
  film::Film film_;
  gl::Profile lit_, unlit_;
  std::optional<draw::StageFloor> floor_;
  double time_ = 0;
};

/// Draws the frames that are not there yet.
FramesMade draw_frames(const ClipJob& job, ClipStates& states, film::RenderWorkers& workers,
                       film::FrameFolder& folder, Profiled* profiled,
                       const program::Common& common) {
  FramesMade made;
  made.renderer = workers.context().description();
  const std::uint64_t shared = job.fingerprint(made.renderer);
  const Provenance provenance = job.provenance();
  const bool transparent = job.options.output.transparent;
  picture::Font font(picture::Font::Weight::regular, picture::Font::Family::lato);
  const auto begin = Clock::now();
  program::Progress progress("rendering", "frames", job.frames.size(), common.quiet);
  std::mutex mutex;  // of everything that counts, and of the font
  std::size_t done = 0;
  const auto draw = [&](film::Film& film, const scenes::ClipSimulation::Shutter& open) {
    render::stop_if_interrupted();
    film.set_transparent(transparent);
    if (profiled) profiled->start();
    const int number = job.frames[open.index];
    const scenes::ClipFrame& frame = job.clip[std::size_t(number)];
    const std::vector<draw::FrameState> shutter = film.shutter(frame, open);
    if (profiled) profiled->lap("pose");
    const std::uint64_t inputs = frame_inputs(shared, frame, shutter);
    const bool is_there = folder.has(number, inputs);
    film::Film::Frame drawn{};
    if (!is_there) drawn = film.draw(frame, shutter);
    const std::lock_guard lock(mutex);
    if (!is_there) {
      made.drawn_again += folder.knows(number);
      if (job.options.certificate)
        film::draw_note(drawn.picture, font, "Certificate: " + job.proof);
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
  };
  workers.run([&]() -> film::RenderWorkers::Work {
    if (states.done()) return {};
    return [&draw, open = states.next()](film::Film& film) { draw(film, open); };
  });
  folder.finish();
  made.simulating = states.time();
  made.drawing = std::chrono::duration<double>(Clock::now() - begin).count() - made.simulating -
                 (profiled ? profiled->time() : 0);
  return made;
}

/// A frame of a graphics card is drawn in less time than it takes to compress.
int writers_beside(const film::RenderWorkers& workers, const program::Common& common) {
  constexpr int kMost = 4;
  if (workers.context().is_software()) return 1;
  const int threads =
      common.threads > 0 ? common.threads : int(std::thread::hardware_concurrency());
  return std::clamp(threads, 1, kMost);
}

}  // namespace

DrawnClip draw_clip(const ClipJob& job, const program::Common& common) {
  const RenderOptions& options = job.options;
  // Clothes are simulated when first asked for: beside the start of the driver.
  const std::future<void> posed =
      std::async([&] { film::instant_of(job.scene, snapshot(job.scene.world)); });
  film::RenderWorkers workers(job.backend, common.threads, options.profile, job.scene,
                              job.scene.width, job.scene.height, options.samples);
  film::FrameFolder folder(job.frame_path, !options.anew, job.size(),
                           writers_beside(workers, common));
  std::optional<Profiled> profiled;
  if (options.profile) profiled.emplace(job, workers);
  studies::SelfEstimate estimate(job.scene, !options.no_estimate && !options.part.is_part());
  ClipStates states(job, estimate);
  const FramesMade made =
      draw_frames(job, states, workers, folder, profiled ? &*profiled : nullptr, common);
  if (!common.quiet && (made.drawn_again > 0 || made.drawn < job.frames.size()))
    program::note(
        "{} of {} frames were there already{}\n", job.frames.size() - made.drawn, job.frames.size(),
        made.drawn_again > 0 ? fmt::format("; {} were made from another scene, program, driver or "
                                           "other options, and are drawn again",
                                           made.drawn_again)
                             : "");
  DrawnClip clip{clip_report(job, made), ""};
  if (profiled) {
    profiled->measure_floor();
    clip.report["profile"] = profiled->json();
    // Where something moves, a pixel has a sample for each exposure.
    clip.profile = fmt::format("{}exposures per frame: {:.2f}\n", profiled->table(made.drawn),
                               made.mean_exposures());
  }
  finish_clip(job, clip.report, estimate, common);
  return clip;
}

// The clip from the frames that its parts drew.

namespace {

/// The results of a part that is done.
struct DonePart {
  std::filesystem::path folder;
  film::FrameFolder::Entries frames;
  std::uint64_t shared = 0;  // what its frames have in common with others of its renderer
  FramesMade made;           // by its last run
};

std::vector<DonePart> done_parts(const ClipJob& job, const std::vector<program::PartPath>& found) {
  std::vector<DonePart> parts;
  for (const program::PartPath& part : found) {
    render::stop_if_interrupted();
    const std::filesystem::path record = part.path / kRecord;
    std::error_code error;
    if (!std::filesystem::exists(record, error)) continue;  // it is not done
    const std::optional<FramesMade> made = frames_made(scenes::read_bytes(record));
    if (!made) continue;
    DonePart done{part.path, film::FrameFolder::whole_frames(part.path, job.size()), 0, *made};
    done.shared = job.fingerprint(made->renderer);
    parts.push_back(std::move(done));
  }
  return parts;
}

}  // namespace

std::optional<FramesMade> frames_made(const std::string& record) {
  const auto json = nlohmann::json::parse(record, nullptr, false);
  if (!json.is_object()) return {};
  FramesMade made;
  try {
    made.renderer = json.value("renderer", "");
    made.drawn = json.value("frames_drawn", std::size_t(0));
    const double drawn = double(made.drawn);
    made.exposures = json.value("mean_exposures", 0.0) * drawn;
    made.drawing =
        json.value(nlohmann::json::json_pointer("/seconds_per_frame/rendering"), 0.0) * drawn;
  } catch (const nlohmann::json::exception&) {  // a key is of another type
    return {};
  }
  return made;
}

int merge_clip(const ClipJob& job, const program::Common& common) {
  const std::vector<program::PartPath> found = program::found_parts(job.out, kParts);
  const std::vector<DonePart> parts = done_parts(job, found);
  studies::SelfEstimate estimate(job.scene, !job.options.no_estimate && !parts.empty());
  std::vector<const DonePart*> owners(job.frames.size());
  std::vector<std::uint64_t> inputs(job.frames.size());
  ClipStates states(job, estimate);
  while (!parts.empty() && !states.done()) {
    const scenes::ClipSimulation::Shutter open = states.next();
    const std::size_t i = open.index;
    const scenes::ClipFrame& frame = job.clip[std::size_t(job.frames[i])];
    const std::vector<draw::FrameState> shutter = film::shutter_of(job.scene, frame, open);
    for (const DonePart& part : parts) {
      const auto entry = part.frames.find(job.frames[i]);
      if (owners[i] || entry == part.frames.end()) continue;
      inputs[i] = frame_inputs(part.shared, frame, shutter);
      if (entry->second.inputs == inputs[i]) owners[i] = &part;
    }
  }
  std::vector<std::size_t> missing;
  std::set<const DonePart*> used;
  for (std::size_t i = 0; i < owners.size(); ++i) {
    if (!owners[i]) missing.push_back(i);
    used.insert(owners[i]);
  }
  program::require_all(missing, job.frames.size(), program::Share::neighbours, found, job.out,
                       "frames");

  film::FrameFolder folder(job.frame_path, true, job.size());
  FramesMade made;
  for (const DonePart& part : parts) {
    if (!used.contains(&part)) continue;
    made.drawn += part.made.drawn;
    made.exposures += part.made.exposures;
    made.drawing += part.made.drawing;
    if (made.renderer.find(part.made.renderer) != std::string::npos) continue;
    made.renderer += (made.renderer.empty() ? "" : "; ") + part.made.renderer;
  }
  for (std::size_t i = 0; i < owners.size(); ++i) {
    render::stop_if_interrupted();
    const int frame = job.frames[i];
    if (folder.has(frame, inputs[i])) continue;
    folder.take(frame, owners[i]->frames.at(frame),
                film::FrameFolder::file(owners[i]->folder, frame));
  }
  made.simulating = states.time();
  nlohmann::ordered_json report = clip_report(job, made);
  finish_clip(job, report, estimate, common);
  render::write_output(result_text(report, common));
  return program::kDone;
}

}  // namespace taut::clips
