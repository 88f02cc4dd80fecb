#include "render/plan/make_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/base/bounded.h"
#include "render/base/interrupt.h"
#include "render/draw/jitter.h"
#include "render/program/command.h"
#include "render/program/progress.h"
#include "scenes/load/plan_file.h"
#include "scenes/scene/clip.h"
#include "sim/motion/side_by_side.h"
#include "sim/motion/stop.h"
#include "sim/study/front.h"
#include "sim/study/refined.h"

namespace taut::planning {
namespace {

constexpr double kCheckWork = 1.5e10;  // cycles of the independent check
constexpr double kFinely = 1e-2;  // of the tolerance: how finely models are solved to score them
constexpr double kFinerForClip = 0.9;
constexpr int kTimings = 5;
// Shares of the budget, each with what those before it left: until which part of it each may go on.
constexpr double kReference = 0.6, kModels = 0.7, kSearch = 0.9;
constexpr double kSolutions = 3;  // of the reference, side by side

/// CPU time for all the work of a plan.
class Budget {
 public:
  explicit Budget(double seconds) : seconds_(seconds) {}

  double seconds() const { return seconds_; }
  /// What is left (s) until that share of it is spent; at least nothing.
  double left(double share) const {
    return std::max(start_ + share * seconds_ - render::process_seconds(), 0.0);
  }

 private:
  double seconds_;
  double start_ = render::process_seconds();
};

/// CPU seconds per simulated second of stepping to the end, within `cap` (s); infinite where it
/// does not get there, not a number where there is no time for one run.
double cost_of(const study::PlanModel& model, const MethodChoice& candidate,
               const std::vector<double>& times, double cap) {
  std::vector<double> costs;
  const WorkLimit limit({.cpu_time = cap});
  try {
    for (int repeat = 0; repeat < kTimings; ++repeat) {
      check_stop();
      costs.push_back(study::time_run({model.world, times, model.timeline}, candidate) /
                      times.back());
    }
  } catch (const OverLimit&) {
    if (costs.empty()) return NAN;
  } catch (const Diverged&) {
    return INFINITY;
  }
  return study::spread(std::move(costs)).median;
}

/// The needs of the clip's blur, where the tolerance is of its pictures.
std::optional<Blur> blur_of(const scenes::Scene& scene, const study::ReferenceSolution& reference,
                            const Asked& asked) {
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
  Blur blur;
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
std::optional<double> error_of_clip(const Planned& planned, double scored,
                                    const std::function<void(double)>& tick, double cap) {
  if (!planned.scene.stage) return std::nullopt;
  scenes::Scene clip = planned.scene;
  clip.method = planned.candidate();
  if (planned.blur) clip.stage->exposures = planned.blur->most;
  const std::vector<double> times = scenes::shown_times(clip, scenes::clip_frames(clip));
  const std::vector<double>& compared = planned.reference.problem.times;
  if (std::ranges::includes(compared, times)) return std::nullopt;
  const study::ReferenceSolution shown =
      study::at_times(planned.reference, scored, times, tick, cap);
  return study::distance_between(shown, planned.model().model.world, planned.model().model.timeline,
                                 planned.candidate(), planned.asked.tolerance.distance, cap);
}

/// The event of the timeline between two frames, in words.
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

/// Solves every model finely, to see how good it is by itself, and gives candidates to those that
/// are good enough: what is beyond the tolerance when it is solved well must not be saved by errors
/// that cancel.
std::vector<study::PlanModel> score_models(std::vector<SceneModel>& scene_models,
                                           const study::ReferenceSolution& reference,
                                           const study::Tolerance& tolerance,
                                           const MethodChoice& finely, int fps, double longest_step,
                                           const Budget& budget, bool quiet) {
  std::vector<study::PlanModel> models;
  program::Progress progress("models", "models", scene_models.size(), quiet);
  constexpr std::size_t kBlock = 4;
  for (std::size_t k = 0; k < scene_models.size(); k += kBlock) {
    render::stop_if_interrupted();
    const double cap =
        budget.left(kModels) / static_cast<double>(std::min(kBlock, scene_models.size() - k));
    side_by_side(std::min(kBlock, scene_models.size() - k), [&](std::size_t i) {
      const study::Tolerance own = tolerance;  // a distance may remember what it was asked last
      SceneModel& one = scene_models[k + i];
      one.alone = cap > 0 ? study::attempt(one.model, finely, reference, own, INFINITY, cap)
                          : study::Trial{.end = study::Trial::End::cut};
    });
    progress.update(k);
  }
  for (SceneModel& one : scene_models) {
    if (one.alone.end == study::Trial::End::within) {
      one.model.candidates = all_candidates(one.model.world, fps, longest_step);
    }
    models.push_back(one.model);
  }
  return models;
}

study::Search search_all(const std::vector<study::PlanModel>& models,
                         const study::ReferenceSolution& reference,
                         const study::Tolerance& tolerance, const Budget& budget, bool quiet) {
  std::size_t total = 0;
  for (const study::PlanModel& model : models) total += model.candidates.size();
  program::Progress progress("planning", "runs", total, quiet);
  return search(
      models, reference, tolerance,
      [&](std::size_t done) {
        render::stop_if_interrupted();
        progress.update(done);
      },
      [&] { return budget.left(kSearch); });
}

scenes::Plan plan_of(const Planned& planned, const std::string& tolerance, std::uint64_t stamp) {
  const study::ReferenceSolution& reference = planned.reference;
  scenes::Plan plan{.tolerance = tolerance,
                    .error = planned.error,
                    .until = reference.known > 1 ? reference.horizon() : 0,
                    .stamp = stamp,
                    .method = planned.candidate(),
                    .particles = planned.model().particles,
                    .links = planned.model().links,
                    .neglected = planned.model().neglected};
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

}  // namespace

Planned make_plan(const scenes::Scene& scene, const std::vector<scenes::SceneChange>& changes,
                  Asked asked, const std::string& tolerance, std::uint64_t stamp, double seconds,
                  bool quiet) {
  const Budget budget(seconds);
  const double scored = asked.tolerance.most / asked.per_metre;
  const auto tick = [](program::Progress& progress) {
    return [&progress](double done) {
      render::stop_if_interrupted();
      progress.update(static_cast<std::size_t>(100 * done));
    };
  };
  const study::ReferenceSolution reference = [&] {
    program::Progress progress("solving the reference", "%", 100, quiet);
    double share = 0;
    try {
      return study::solve_reference(
          {few_copies(scene.world, scene.timeline), study::frame_times(scene.duration, scene.fps),
           scene.timeline},
          scored, kCheckWork,
          [&](double done) {
            share = done;
            tick(progress)(done);
          },
          budget.left(kReference) / kSolutions);
    } catch (const OverLimit&) {
      throw program::Misuse(fmt::format(
          "--budget {}: {:.0f} s of CPU time solve {:.2g}% of what there is to compare with, and "
          "nothing is planned; a larger budget, a coarser tolerance or a shorter scene (--set "
          "duration=...) help",
          seconds, kReference * seconds, 100 * share));
    }
  }();
  const std::optional<Blur> blur = blur_of(scene, reference, asked);
  asked.tolerance.most -= asked.per_metre * reference.self_error;

  const MethodChoice finely{"direct", {{"tolerance", scored * kFinely}}};
  std::vector<SceneModel> scene_models = models_of(
      scene, changes,
      negligible_physics(scene, reference, finely, asked.tolerance, budget.left(kModels)));
  const std::vector<study::PlanModel> models =
      score_models(scene_models, reference, asked.tolerance, finely, scene.fps,
                   blur ? blur->longest_step : INFINITY, budget, quiet);

  // Between frames a clip may show what is farther off than at any frame: then once more, finer.
  for (study::Tolerance within = asked.tolerance;;) {
    const study::Search search = search_all(models, reference, within, budget, quiet);
    std::size_t left_out = search.left_out;
    for (const SceneModel& model : scene_models) {
      if (model.alone.end == study::Trial::End::cut) ++left_out;
    }
    if (!search.best && left_out > 0) {
      throw program::Misuse(fmt::format(
          "--budget {}: {} models and settings were left out, and of the others none comes within "
          "{}; a larger budget, a coarser tolerance or a shorter scene (--set duration=...) help",
          seconds, left_out, tolerance));
    }
    if (!search.best) {
      const study::Trial* trial = nearest(search, scene_models);
      const SceneModel& model = trial ? scene_models[trial->model] : scene_models.front();
      throw program::Misuse(fmt::format(
          "--tolerance {}: no method at any of its settings comes so near; nearest: {}, {}: {}",
          tolerance, describe(model, scene),
          trial ? describe(models[trial->model].candidates[trial->candidate]) : "solved finely",
          outcome(trial ? *trial : model.alone, asked, reference)));
    }
    Planned planned{scene, asked, reference, scene_models, search, search.trials[*search.best]};
    planned.scored = scored;
    planned.blur = blur;
    planned.error = planned.best.error;
    planned.left_out = left_out;
    planned.budget = seconds;
    const auto rest = [&] { return budget.left(1); };
    if (reference.known > 1) try {
        program::Progress progress("proving the clip", "%", 100, quiet);
        planned.clip_error = error_of_clip(planned, scored, tick(progress), rest());
        planned.error = std::max(planned.error, planned.clip_error.value_or(0));
      } catch (const OverLimit&) {
        throw program::Misuse(fmt::format(
            "--budget {}: {} by {} is within {} at every frame, and no time was left to prove what "
            "the clip shows between them; a larger budget helps",
            seconds, describe(planned.model(), scene), describe(planned.candidate()), tolerance));
      }
    if (planned.error > asked.tolerance.most) {
      within.most *= kFinerForClip * asked.tolerance.most / planned.error;
      continue;
    }
    const study::PlanModel& written = models.front();
    planned.as_written =
        study::run_through(written, scene.method, reference, asked.tolerance.distance, rest());
    planned.models_off = model_errors(scene, changes, scene_models, reference, finely,
                                      asked.tolerance.distance, rest);
    const std::vector<double>& times = reference.problem.times;
    planned.cost = cost_of(planned.model().model, planned.candidate(), times, rest());
    planned.cost_as_written = planned.as_written.end == study::Trial::End::cut
                                  ? NAN
                                  : cost_of(written, scene.method, times, rest());
    planned.plan = plan_of(planned, tolerance, stamp);
    return planned;
  }
}

}  // namespace taut::planning
