// taut plan: the cheapest model of a scene that nobody can tell from the exact one.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>

#include "render/atomic_file.h"
#include "render/cli/command.h"
#include "render/cli/plan_report.h"
#include "render/cli/progress.h"
#include "render/cli/study_options.h"
#include "render/cli/study_target.h"
#include "render/interrupt.h"
#include "sim/study/front.h"

namespace taut::cli {
namespace {

constexpr double kCheckWork = 5e9;  // of the independent check, about as many ns
constexpr double kFinely = 1e-2;    // of the tolerance: how finely models are solved to judge them
constexpr int kTimings = 5;

struct Options {
  std::string scene, tolerance;
  bool write = false;
};

/// "1px" or "0.5mm".
Asked asked_for(const std::string& text, const Scene& scene) {
  Asked asked;
  const char* const end = text.data() + text.size();
  const auto [unit, error] = std::from_chars(text.data(), end, asked.tolerance.most);
  asked.unit = std::string(unit, end);
  if (error != std::errc() || !(asked.tolerance.most > 0) || !std::isfinite(asked.tolerance.most) ||
      (asked.unit != "px" && asked.unit != "mm")) {
    throw Misuse(
        fmt::format("--tolerance {}: expected a number above 0 and px or mm, as in 1px", text));
  }
  if (asked.unit == "mm") {
    asked.per_metre = 1e3;
    asked.tolerance.distance = [](const Vec3& at, const Vec3& truth, double) {
      return 1e3 * (at - truth).norm();
    };
    return asked;
  }
  const auto metric = pixels_of(scene);
  if (!metric) {
    throw Misuse(fmt::format("--tolerance {}: {} has no camera; give the tolerance in mm", text,
                             scene.file.string()));
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
  if (asked.per_metre == 0) throw Misuse("the camera never sees where the connector starts");
  return asked;
}

/// CPU seconds per simulated second of stepping to the end; infinite where it does not get there.
double cost_of(const PlanModel& model, const Candidate& candidate,
               const std::vector<double>& times) {
  std::vector<double> costs;
  try {
    for (int repeat = 0; repeat < kTimings; ++repeat) {
      stop_if_interrupted();
      costs.push_back(time_run({model.world, times, model.timeline}, candidate) / times.back());
    }
  } catch (const Diverged&) {
    return INFINITY;
  }
  return spread(std::move(costs)).median;
}

/// How many exposures leave no point of what moves farther than the tolerance from one of them
/// while the shutter is open.
std::optional<Exposures> exposures_for(const Scene& scene, const Exact& exact,
                                       const Tolerance& tolerance) {
  if (!scene.stage || scene.stage->shutter == 0) return std::nullopt;
  Exposures exposures;
  for (std::size_t k = 1; k < exact.points.size(); ++k) {
    for (std::size_t i = 0; i < exact.points[k].size(); ++i) {
      const double way =
          tolerance.distance(exact.points[k][i], exact.points[k - 1][i], exact.problem.times[k]);
      if (std::isfinite(way)) exposures.way = std::max(exposures.way, way * scene.stage->shutter);
    }
  }
  exposures.count = static_cast<int>(std::max(1.0, std::ceil(exposures.way / 2 / tolerance.most)));
  return exposures;
}

void write(const Scene& scene, const Plan& plan) {
  std::ifstream in(scene.file, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  AtomicFile file(scene.file);
  file.write(with_plan(text, plan));
  file.commit();
}

int run(const Options& options, const Common& common) {
  const Scene scene = load_scene(options.scene, true);
  if (scene.world.connectors.empty()) {
    throw Misuse(fmt::format("{}: has no connector to plan for", options.scene));
  }
  Asked asked = asked_for(options.tolerance, scene);

  const double scored = asked.tolerance.most / asked.per_metre;
  const Exact exact = [&] {
    Progress progress("solving exactly", "%", 100, common.quiet);
    return solve_exactly(
        {few_copies(scene.world), frame_times(scene.duration, scene.fps), scene.timeline}, scored,
        kCheckWork, [&](double done) {
          stop_if_interrupted();
          progress.update(static_cast<std::size_t>(100 * done));
        });
  }();
  asked.tolerance.most -= asked.per_metre * exact.self_error;

  std::vector<SceneModel> scene_models = models_of(scene);
  std::vector<PlanModel> models;
  std::size_t total = 0;
  const Candidate finely{"direct", {{"tolerance", scored * kFinely}}};
  {
    Progress progress("models", "models", scene_models.size(), common.quiet);
    for (SceneModel& one : scene_models) {
      stop_if_interrupted();
      one.alone = attempt(one.model, finely, exact, asked.tolerance, INFINITY);
      // What is beyond the tolerance when it is solved well must not be saved by errors that
      // cancel.
      if (one.alone.end == Trial::End::within)
        one.model.candidates = all_candidates(one.model.world, scene.fps);
      models.push_back(one.model);
      total += one.model.candidates.size();
      progress.update(models.size());
    }
  }
  Search search;
  {
    Progress progress("planning", "runs", total, common.quiet);
    search = taut::search(models, exact, asked.tolerance, [&](std::size_t done) {
      stop_if_interrupted();
      progress.update(done);
    });
  }
  if (!search.best) {
    const Trial* trial = nearest(search, scene_models);
    const SceneModel& model = trial ? scene_models[trial->model] : scene_models.front();
    throw Misuse(fmt::format(
        "--tolerance {}: no method at any of its settings comes so near; nearest: {}, {}: {}",
        options.tolerance, describe(model, scene),
        trial ? describe(model.model.candidates[trial->candidate]) : "solved finely",
        outcome(trial ? *trial : model.alone, asked, exact)));
  }

  Planned planned{scene, asked, exact, scene_models, search, search.trials[*search.best]};
  const Candidate as_written{scene.method.name, scene.method.settings};
  const PlanModel& written = models.front();
  planned.as_written = run_through(written, as_written, exact, asked.tolerance.distance);
  planned.models_off = model_errors(scene, scene_models, exact, finely, asked.tolerance.distance);
  planned.scored = scored;
  planned.exposures = exposures_for(scene, exact, asked.tolerance);
  planned.cost = cost_of(planned.model().model, planned.candidate(), exact.problem.times);
  planned.cost_as_written = cost_of(written, as_written, exact.problem.times);
  planned.plan = {options.tolerance,
                  planned.best.error,
                  exact.known > 1 ? exact.horizon() : 0,
                  {},
                  plan_stamp(scene.file),
                  {planned.candidate().method, planned.candidate().settings},
                  planned.model().particles};
  if (exact.goes_on() && exact.closed) planned.plan.energy = planned.best.later.energy;
  if (options.write) write(scene, planned.plan);
  write_output(common.json ? plan_json(planned) : plan_text(planned));
  return kDone;
}

}  // namespace

void add_plan(CLI::App& app, Program& program) {
  CLI::App& command = add_command(app, program, "plan",
                                  "The cheapest model that nobody can tell from the exact one",
                                  R"(  taut plan scenes/rope_swing.toml --tolerance 1px
  taut plan scenes/nunchaku.toml --tolerance 0.5mm
  taut plan scenes/rope_swing.toml --tolerance 1px --write
  taut render scenes/rope_swing.toml --planned

It chooses the number of particles, the method and its settings, by counts of work, so that the same
scene has the same plan on every machine. The scene as it is written, solved to convergence, is what
it compares with: every particle and the ends of every body, at every frame as long as the motion is
predictable. --write keeps the plan in the scene file; a scene that changed since says so.)");
  const auto options = std::make_shared<Options>();
  command.add_option("scene", options->scene, "A scene file")->required();
  command
      .add_option("--tolerance", options->tolerance,
                  "How far any point may be from where it should be: 1px on the picture, or 0.5mm")
      ->required();
  command.add_flag("--write", options->write, "Write the plan into the scene file");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
