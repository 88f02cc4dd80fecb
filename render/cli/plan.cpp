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
#include "sim/measure.h"
#include "sim/study/front.h"
#include "sim/study/stability.h"
#include "sim/truth/truth.h"

namespace taut::cli {
namespace {

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

/// CPU seconds per simulated second up to `end` of the scene as the model and candidate have it.
double cost_of(const PlanModel& model, const Candidate& candidate, double end, int fps) {
  std::vector<double> costs;
  for (int repeat = 0; repeat < 5; ++repeat) {
    stop_if_interrupted();
    Simulation simulation(model.world, make_method(candidate.method, candidate.settings),
                          model.timeline);
    const double before = thread_seconds();
    for (const double time : frame_times(end, fps)) simulation.advance_to(time);
    costs.push_back((thread_seconds() - before) / end);
  }
  return spread(std::move(costs)).median;
}

Spread speeds_of(std::span<const Snapshot> frames, double from) {
  std::vector<double> speeds;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    if (frames[k].time <= from) continue;
    const double dt = frames[k].time - frames[k - 1].time;
    for (std::size_t c = 0; c < frames[k].connectors.size(); ++c) {
      for (std::size_t i = 0; i < frames[k].connectors[c].size(); ++i) {
        speeds.push_back((frames[k].connectors[c][i] - frames[k - 1].connectors[c][i]).norm() / dt);
      }
    }
  }
  return spread(std::move(speeds));
}

Afterwards afterwards(const PlanModel& model, const Candidate& candidate, const Truth& truth) {
  Afterwards result;
  Simulation simulation(model.world, make_method(candidate.method, candidate.settings),
                        model.timeline);
  const auto energy = [&] {
    return kinetic_energy(simulation.world()) + potential_energy(simulation.world());
  };
  const double before = energy();
  double change = 0;
  std::vector<Snapshot> frames;
  for (const Snapshot& frame : truth.frames) {
    stop_if_interrupted();
    simulation.advance_to(frame.time);
    frames.push_back(simulation.state());
    change = std::max(change, std::abs(energy() - before));
    result.stretch = std::max(result.stretch, stretch_max(simulation.world()));
  }
  if (!is_driven(model.world) && model.timeline.empty()) {
    result.energy = change / available_energy(model.world);
  }
  result.speeds = speeds_of(frames, truth.horizon);
  result.true_speeds = speeds_of(truth.frames, truth.horizon);
  return result;
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

  if (!common.quiet) fmt::print(stderr, "solving the truth\n");
  TruthOptions accuracy;
  accuracy.scored_error = asked.tolerance.most / asked.per_metre;
  const std::vector<double> times = frame_times(scene.duration, scene.fps);
  const Truth truth = solve_truth(scene.world, times, accuracy, scene.timeline);
  Reference reference{truth.frames, truth.horizon, truth.self_error};
  std::erase_if(reference.frames,
                [&](const Snapshot& frame) { return frame.time > truth.horizon; });
  if (reference.frames.size() < 2) {
    throw Misuse(fmt::format("{}: nothing is predictable to {}", options.scene, options.tolerance));
  }
  asked.tolerance.most -= asked.per_metre * truth.self_error;

  std::vector<SceneModel> scene_models = models_of(scene);
  std::vector<PlanModel> models;
  std::size_t total = 0;
  for (SceneModel& one : scene_models) {
    stop_if_interrupted();
    const Candidate finely{"direct", {{"tolerance", accuracy.scored_error / 100}}};
    one.error = error_along(one.model.world, one.model.timeline, finely, scene.world, reference,
                            asked.tolerance.distance);
    // What is beyond the tolerance when it is solved well must not be saved by errors that cancel.
    if (one.error <= asked.tolerance.most) one.model.candidates = all_candidates(scene.fps);
    models.push_back(one.model);
    total += one.model.candidates.size();
  }
  Search search;
  {
    Progress progress("planning", "runs", total, common.quiet);
    search = taut::search(models, scene.world, reference, asked.tolerance, [&](std::size_t done) {
      stop_if_interrupted();
      progress.update(done);
    });
  }
  if (!search.best) {
    throw Misuse(fmt::format("--tolerance {}: no method at any of its settings comes so near",
                             options.tolerance));
  }

  Planned planned{scene, asked, truth, scene_models, search, search.trials[*search.best], {}, {}};
  const Candidate as_written{scene.method.name, scene.method.settings};
  const PlanModel& written = models.front();
  planned.error_as_written = error_along(written.world, written.timeline, as_written, scene.world,
                                         reference, asked.tolerance.distance);
  planned.after = afterwards(planned.model().model, planned.candidate(), truth);
  planned.cost = cost_of(planned.model().model, planned.candidate(), truth.horizon, scene.fps);
  planned.cost_as_written = cost_of(written, as_written, truth.horizon, scene.fps);
  {
    Simulation simulation(written.world, make_method(as_written.method, as_written.settings),
                          written.timeline);
    for (const Snapshot& frame : reference.frames) simulation.advance_to(frame.time);
    planned.work_as_written =
        work_of(as_written, simulation.world(), simulation.method().counters()) / truth.horizon;
  }
  planned.plan = {options.tolerance,
                  planned.best.error,
                  truth.horizon,
                  planned.after.energy,
                  plan_stamp(scene.file),
                  {planned.candidate().method, planned.candidate().settings},
                  planned.model().particles};
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
