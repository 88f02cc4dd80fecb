// taut plan: the cheapest model of a scene that nobody can tell from the reference solution.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "render/base/interrupt.h"
#include "render/draw/jitter.h"
#include "render/options/study_options.h"
#include "render/plan/plan_report.h"
#include "render/program/command.h"
#include "render/program/progress.h"
#include "render/study/study_target.h"
#include "scenes/files/regular_file.h"
#include "scenes/load/load_scene.h"
#include "scenes/load/plan_file.h"
#include "scenes/scene/clip.h"
#include "sim/evaluation/side_by_side.h"
#include "sim/study/front.h"
#include "sim/study/refined.h"

namespace taut::cli {
namespace plan_command {
namespace {

namespace fs = std::filesystem;

constexpr double kCheckWork = 1.5e10;  // cycles of the independent check
constexpr double kFinely = 1e-2;  // of the tolerance: how finely models are solved to score them
constexpr double kFinerForClip = 0.9;
constexpr int kTimings = 5;

struct Options {
  options::SceneOptions inputs;
  std::string scene, tolerance;
  bool write = false;
};

/// "1px" or "0.5mm".
planning::Asked asked_for(const std::string& text, const scenes::Scene& scene) {
  const auto length = scenes::read_length(text);
  if (!length) {
    throw program::Misuse(
        fmt::format("--tolerance {}: expected a number above 0 and px or mm, as in 1px", text));
  }
  planning::Asked asked{.tolerance = {{}, length->number}, .unit = std::string(length->unit)};
  if (asked.unit == "mm") {
    asked.per_metre = 1e3;
    asked.tolerance.distance = [](const Vec3& at, const Vec3& truth, double) {
      return 1e3 * (at - truth).norm();
    };
    return asked;
  }
  const auto metric = studies::pixels_of(scene);
  if (!metric) {
    throw program::Misuse(fmt::format("--tolerance {}: {} has no camera; give the tolerance in mm",
                                      text, scene.file.string()));
  }
  asked.tolerance.distance = metric->distance;
  constexpr double kNear = 1e-4;  // m
  for (int k = 0; k < scene.frames(); ++k) {
    const double time = double(k) / scene.fps;
    for (const auto& particles : snapshot(scene.world).connectors) {
      for (const Vec3& at : particles) {
        for (const Vec3 side : {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}) {
          const double pixels = metric->distance(at + kNear * side, at, time);
          if (std::isfinite(pixels)) asked.per_metre = std::max(asked.per_metre, pixels / kNear);
        }
      }
    }
  }
  if (asked.per_metre == 0)
    throw program::Misuse("the camera never sees where the connector starts");
  return asked;
}

/// CPU seconds per simulated second of stepping to the end; infinite where it does not get there.
double cost_of(const study::PlanModel& model, const study::Candidate& candidate,
               const std::vector<double>& times) {
  std::vector<double> costs;
  try {
    for (int repeat = 0; repeat < kTimings; ++repeat) {
      render::stop_if_interrupted();
      costs.push_back(study::time_run({model.world, times, model.timeline}, candidate) /
                      times.back());
    }
  } catch (const Diverged&) {
    return INFINITY;
  }
  return study::spread(std::move(costs)).median;
}

/// What the blur of the clip needs, where the tolerance is of its pictures.
std::optional<planning::Blur> blur_of(const scenes::Scene& scene,
                                      const study::ReferenceSolution& reference,
                                      const planning::Asked& asked) {
  if (!scene.stage || scene.stage->shutter == 0 || asked.unit != "px") return std::nullopt;
  // Of the frame from the time of each state to the next, the most that a point comes, px.
  std::vector<double> ways;
  for (std::size_t k = 1; k < reference.points.size(); ++k) {
    double most = 0;
    for (std::size_t i = 0; i < reference.points[k].size(); ++i) {
      const double way = asked.tolerance.distance(
          reference.points[k][i], reference.points[k - 1][i], reference.problem.times[k]);
      if (std::isfinite(way)) most = std::max(most, way);
    }
    ways.push_back(most);
  }
  constexpr int kSamples = 4;  // of a pixel, as render has them unless it is told otherwise
  const double apart = 2 * asked.tolerance.most;
  planning::Blur blur;
  double fastest = 0, frames = 0;
  for (const scenes::ClipFrame& frame : scenes::clip_frames(scene)) {
    const auto k = static_cast<std::size_t>(frame.time * scene.fps);
    if (frame.card || k >= ways.size()) continue;
    const double way = ways[k] * scene.stage->shutter * frame.rate;
    const auto taken = [&](double gap, int most) {
      const std::vector<draw::Exposures> grades = draw::exposures(way, kSamples, most, gap);
      return way > 1 && !grades.empty() ? grades.back().count : 1;
    };
    fastest = std::max(fastest, ways[k] * scene.fps);
    blur.way = std::max(blur.way, way);
    blur.mean += taken(apart, scenes::kMostStates);
    blur.mean_as_written += taken(scene.stage->exposures_apart, scene.stage->exposures);
    blur.most = std::max(blur.most, taken(apart, scenes::kMostStates));
    ++frames;
  }
  if (frames == 0) return std::nullopt;
  blur.mean /= frames;
  blur.mean_as_written /= frames;
  blur.apart = blur.way / blur.most;
  if (blur.most > 1) blur.longest_step = std::max(apart, blur.apart) / fastest;
  return blur;
}

/// The most that the planned motion is off at all instants that the clip shows, as far as it is
/// predictable; none where these are the frames that the planner compares anyway.
std::optional<double> error_of_clip(const planning::Planned& planned, double scored,
                                    const std::function<void(double)>& tick) {
  if (!planned.scene.stage) return std::nullopt;
  scenes::Scene clip = planned.scene;
  clip.method = {planned.candidate().method, planned.candidate().settings};
  if (planned.blur) clip.stage->exposures = planned.blur->most;
  const std::vector<double> times = scenes::shown_times(clip, scenes::clip_frames(clip));
  const std::vector<double>& compared = planned.reference.problem.times;
  if (std::ranges::includes(compared, times)) return std::nullopt;
  const study::ReferenceSolution shown = study::at_times(planned.reference, scored, times, tick);
  return study::distance_between(shown, planned.model().model.world, planned.model().model.timeline,
                                 planned.candidate(), planned.asked.tolerance.distance);
}

/// What the timeline does between two frames, in words.
std::string event_between(const Timeline& timeline, double from, double until) {
  const auto within = [&](double time) { return time >= from && time <= until; };
  for (const TimedPin& pin : timeline.pins) {
    if (within(pin.from)) return "a pin comes";
    if (within(pin.from + pin.over)) return "a pin arrives";
    if (within(pin.until)) return "a pin lets go";
  }
  for (const TimedCut& cut : timeline.cuts) {
    if (within(cut.time)) return "it is cut";
  }
  return {};
}

/// The scene file, to be written once its plan is found: says beforehand if it cannot be.
class PlanFile {
 public:
  explicit PlanFile(const fs::path& scene)
      : scene_(fs::canonical(scene)), stamp_(scenes::plan_stamp(scene)) {
    if ((fs::status(scene_).permissions() & fs::perms::owner_write) == fs::perms::none) {
      throw render::CannotWrite(
          fmt::format("{}: is read-only, and --write would change it", scene.string()));
    }
    file_.emplace(scene_);
  }

  void write(const scenes::Plan& plan) {
    if (scenes::plan_stamp(scene_) != stamp_) {
      throw render::CannotWrite(
          fmt::format("{}: has changed while it was planned; plan it again", scene_.string()));
    }
    file_->write(scenes::with_plan(scenes::read_bytes(scene_), plan));
    file_->commit();
  }

 private:
  fs::path scene_;
  std::uint64_t stamp_;
  std::optional<render::AtomicFile> file_;
};

/// Solves every model finely, to see how good it is by itself, and gives candidates to those that
/// are good enough: what is beyond the tolerance when it is solved well must not be saved by errors
/// that cancel.
std::vector<study::PlanModel> score_models(std::vector<planning::SceneModel>& scene_models,
                                           const study::ReferenceSolution& reference,
                                           const study::Tolerance& tolerance,
                                           const study::Candidate& finely, int fps,
                                           double longest_step, bool quiet) {
  std::vector<study::PlanModel> models;
  program::Progress progress("models", "models", scene_models.size(), quiet);
  constexpr std::size_t kBlock = 4;
  for (std::size_t k = 0; k < scene_models.size(); k += kBlock) {
    render::stop_if_interrupted();
    study::side_by_side(std::min(kBlock, scene_models.size() - k), [&](std::size_t i) {
      const study::Tolerance own = tolerance;  // a distance may remember what it was asked last
      planning::SceneModel& one = scene_models[k + i];
      one.alone = study::attempt(one.model, finely, reference, own, INFINITY);
    });
    progress.update(k);
  }
  for (planning::SceneModel& one : scene_models) {
    if (one.alone.end == study::Trial::End::within) {
      one.model.candidates = planning::all_candidates(one.model.world, fps, longest_step);
    }
    models.push_back(one.model);
  }
  return models;
}

study::Search search_all(const std::vector<study::PlanModel>& models,
                         const study::ReferenceSolution& reference,
                         const study::Tolerance& tolerance, bool quiet) {
  std::size_t total = 0;
  for (const study::PlanModel& model : models) total += model.candidates.size();
  program::Progress progress("planning", "runs", total, quiet);
  return search(models, reference, tolerance, [&](std::size_t done) {
    render::stop_if_interrupted();
    progress.update(done);
  });
}

scenes::Plan plan_of(const planning::Planned& planned, const std::string& tolerance,
                     std::uint64_t stamp) {
  const study::ReferenceSolution& reference = planned.reference;
  scenes::Plan plan{.tolerance = tolerance,
                    .error = planned.error,
                    .until = reference.known > 1 ? reference.horizon() : 0,
                    .stamp = stamp,
                    .method = {planned.candidate().method, planned.candidate().settings},
                    .particles = planned.model().particles,
                    .links = planned.model().links};
  plan.program = scenes::method_stamp(plan.method);
  if (planned.blur) plan.exposures = planned.blur->most;
  if (reference.goes_on()) {
    const std::size_t last = reference.known > 0 ? reference.known - 1 : 0;
    if (reference.known > 1) {
      plan.end = event_between(reference.problem.timeline, reference.problem.times[last],
                               reference.problem.times[last + 1]);
    }
    using Work = scenes::Plan::Afterwards::Work;
    const study::Difference& later = planned.best.later;
    plan.afterwards = {reference.closed     ? Work::none
                       : reference.balanced ? Work::known
                                            : Work::unknown,
                       later.energy, later.stretch, later.speeds};
  }
  return plan;
}

int run(const Options& options, const program::Common& common) {
  const std::vector<scenes::SceneChange> changes = options::scene_changes(options.inputs.set);
  if (options.write && !changes.empty()) {
    throw program::Misuse("--write: the plan would be of another scene than the file's (--set)");
  }
  if (options.write && options.scene == "-") {
    throw program::Misuse("--write: standard input is no file to write the plan into");
  }
  const scenes::Scene scene = scenes::load_scene(options.scene, true, changes);
  if (scene.world.connectors.empty()) {
    throw program::Misuse(fmt::format("{}: has no connector to plan for", options.scene));
  }
  const auto refuse = [&](bool there, const char* what) {
    if (!there) return;
    throw program::Misuse(
        fmt::format("{}: {}, which plans do not follow yet", options.scene, what));
  };
  refuse(!scene.world.obstacles.empty(), "has obstacles");
  refuse(!scene.world.pairs.empty(), "has bodies that touch each other");
  refuse(has_strings(scene.world), "has links that only pull");
  refuse(!scene.world.joints.empty(), "joins connectors");
  planning::Asked asked = asked_for(options.tolerance, scene);
  const std::uint64_t stamp = scenes::plan_stamp(scene.file);
  std::optional<PlanFile> file;
  if (options.write) file.emplace(scene.file);

  const double scored = asked.tolerance.most / asked.per_metre;
  const auto tick = [](program::Progress& progress) {
    return [&progress](double done) {
      render::stop_if_interrupted();
      progress.update(static_cast<std::size_t>(100 * done));
    };
  };
  const study::ReferenceSolution reference = [&] {
    program::Progress progress("solving the reference", "%", 100, common.quiet);
    return study::solve_reference({planning::few_copies(scene.world),
                                   study::frame_times(scene.duration, scene.fps), scene.timeline},
                                  scored, kCheckWork, tick(progress));
  }();
  const std::optional<planning::Blur> blur = blur_of(scene, reference, asked);
  asked.tolerance.most -= asked.per_metre * reference.self_error;

  const study::Candidate finely{"direct", {{"tolerance", scored * kFinely}}};
  std::vector<planning::SceneModel> scene_models = planning::models_of(scene, changes);
  const std::vector<study::PlanModel> models =
      score_models(scene_models, reference, asked.tolerance, finely, scene.fps,
                   blur ? blur->longest_step : INFINITY, common.quiet);

  // Between frames a clip may show what is farther off than at any frame: then once more, finer.
  for (study::Tolerance tolerance = asked.tolerance;;) {
    const study::Search search = search_all(models, reference, tolerance, common.quiet);
    if (!search.best) {
      const study::Trial* trial = planning::nearest(search, scene_models);
      const planning::SceneModel& model = trial ? scene_models[trial->model] : scene_models.front();
      throw program::Misuse(fmt::format(
          "--tolerance {}: no method at any of its settings comes so near; nearest: {}, {}: {}",
          options.tolerance, describe(model, scene),
          trial ? describe(models[trial->model].candidates[trial->candidate]) : "solved finely",
          planning::outcome(trial ? *trial : model.alone, asked, reference)));
    }
    planning::Planned planned{scene,        asked,  reference,
                              scene_models, search, search.trials[*search.best]};
    planned.scored = scored;
    planned.blur = blur;
    planned.error = planned.best.error;
    if (reference.known > 1) {
      program::Progress progress("proving the clip", "%", 100, common.quiet);
      planned.clip_error = error_of_clip(planned, scored, tick(progress));
      planned.error = std::max(planned.error, planned.clip_error.value_or(0));
    }
    if (planned.error > asked.tolerance.most) {
      tolerance.most *= kFinerForClip * asked.tolerance.most / planned.error;
      continue;
    }
    const study::Candidate as_written{scene.method.name, scene.method.settings};
    const study::PlanModel& written = models.front();
    planned.as_written =
        study::run_through(written, as_written, reference, asked.tolerance.distance);
    planned.models_off = planning::model_errors(scene, changes, scene_models, reference, finely,
                                                asked.tolerance.distance);
    planned.cost = cost_of(planned.model().model, planned.candidate(), reference.problem.times);
    planned.cost_as_written = cost_of(written, as_written, reference.problem.times);
    planned.plan = plan_of(planned, options.tolerance, stamp);
    if (file) file->write(planned.plan);
    render::write_output(common.json ? planning::plan_json(planned) : planning::plan_text(planned));
    return program::kDone;
  }
}

}  // namespace
}  // namespace plan_command

void add_plan(CLI::App& app, program::Program& program) {
  using namespace plan_command;
  program::Command command = program::add_command(
      app, program, "plan", "The cheapest model that nobody can tell from the reference solution",
      R"(  taut plan scenes/rope_swing.toml --tolerance 1px
  taut plan scenes/nunchaku.toml --tolerance 0.5mm
  taut plan scenes/rope_swing.toml --tolerance 1px --write
  taut render scenes/rope_swing.toml --planned

It chooses the number of particles or a massless span, rigid bodies or links in their place, the
method with its settings, and the exposures of the motion blur; by counts of work, so that the same
scene has the same plan on every machine. The scene as it is written, solved to convergence, is what
it compares with: every particle and the ends of every body, at every frame and at all that the clip
shows between them, as long as the motion is predictable; after that energy, stretch and speeds.
Pixels are those of the scene's shots, a picture as high as the scene's.

--write keeps the plan in the scene file, as its table [plan]; render and simulate take it with
--planned. It is refused once the scene, or how the program's method moves, is another one.
--json has all of it. Exit codes: 0 found, 2 no method comes so near, or the tolerance makes no
sense, 3 bad scene, 6 the scene file cannot be written, 130 interrupted)");
  const auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->inputs);
  command
      .add_option("--tolerance", options->tolerance,
                  "How far any point may be from where it should be: 1px on the picture, or 0.5mm")
      .required();
  command.add_flag("--write", options->write, "Write the plan into the scene file");
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
