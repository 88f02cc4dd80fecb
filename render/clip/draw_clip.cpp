// The frames of a clip, drawn.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "render/base/interrupt.h"
#include "render/chart/table.h"
#include "render/clip/clip_job.h"
#include "render/clip/profile_report.h"
#include "render/draw/stage_floor.h"
#include "render/film/caption.h"
#include "render/film/render_workers.h"
#include "render/gl/profile.h"
#include "render/program/note.h"
#include "render/program/progress.h"
#include "render/program/terminal.h"

namespace taut::clips {
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
  const options::Provenance provenance = job.provenance();
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

}  // namespace taut::clips
