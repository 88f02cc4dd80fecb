// taut plan: the cheapest model of a scene that nobody can tell from the exact one.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "render/atomic_file.h"
#include "render/cli/command.h"
#include "render/cli/method_options.h"
#include "render/cli/plan_models.h"
#include "render/cli/progress.h"
#include "render/cli/study_options.h"
#include "render/cli/study_target.h"
#include "render/interrupt.h"
#include "render/table.h"
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

struct Asked {
  Tolerance tolerance;
  std::string unit;      // "px" or "mm"
  double per_metre = 0;  // the most units that a metre has
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

/// What can be compared once motions are no longer predictable.
struct Afterwards {
  std::optional<double> energy;  // the largest change, of what the world can turn into motion
  double stretch = 0;            // the largest of a link
  Spread speeds, true_speeds;    // m/s, of all particles from the horizon on
};

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

struct Planned {
  const Scene& scene;
  const Asked& asked;
  const Truth& truth;
  const std::vector<SceneModel>& models;
  const Search& search;
  const Trial& best;
  Plan plan;
  Afterwards after;
  double work_as_written = 0, cost = 0, cost_as_written = 0, error_as_written = 0;

  const SceneModel& model() const { return models[best.model]; }
  const Candidate& candidate() const { return model().model.candidates[best.candidate]; }
};

std::string outcome(const Trial& trial, const std::string& unit) {
  switch (trial.end) {
    case Trial::End::within:
      return fmt::format("{} {} off", rounded(trial.error), unit);
    case Trial::End::beyond:
      return fmt::format("at least {} {} off", rounded(trial.error), unit);
    case Trial::End::dearer:
      return "dearer";
    case Trial::End::diverged:
      return "cannot run it";
  }
  return "";
}

/// What came nearest to being chosen of the trials that `wanted` names: the cheapest within, else
/// one that was only too dear, else the least error.
const Trial* nearest(const Search& search, const auto& wanted) {
  const Trial* best = nullptr;
  for (const Trial& trial : search.trials) {
    if (!wanted(trial)) continue;
    const auto rank = [](const Trial& t) {
      const bool by_work = t.end == Trial::End::within;
      return std::tuple(by_work                       ? 0
                        : t.end == Trial::End::dearer ? 1
                        : t.end == Trial::End::beyond ? 2
                                                      : 3,
                        by_work ? t.work : t.error);
    };
    if (!best || rank(trial) < rank(*best)) best = &trial;
  }
  return best;
}

/// Models beyond the tolerance however well they are solved, and of every other method what came
/// nearest to being chosen.
Table left_out(const Planned& planned) {
  Table table{{"model", "method", "outcome"}, {}};
  const auto method_of = [&](const Trial& trial) {
    return planned.models[trial.model].model.candidates[trial.candidate].method;
  };
  for (const SceneModel& model : planned.models) {
    if (!model.model.candidates.empty()) continue;
    table.add({describe(model, planned.scene), "any",
               fmt::format("{} {} off", rounded(model.error), planned.asked.unit)});
  }
  for (const MethodInfo& method : methods()) {
    if (method.name == planned.candidate().method) continue;
    const Trial* trial =
        nearest(planned.search, [&](const Trial& t) { return method_of(t) == method.name; });
    if (!trial) continue;
    const SceneModel& model = planned.models[trial->model];
    table.add({describe(model, planned.scene), describe(model.model.candidates[trial->candidate]),
               outcome(*trial, planned.asked.unit)});
  }
  return table;
}

std::string times_less(double before, double now) {
  return now <= before ? fmt::format("{} times less", rounded(before / now))
                       : fmt::format("{} times more", rounded(now / before));
}

std::string as_text(const Planned& planned) {
  const Scene& scene = planned.scene;
  std::string text = fmt::format("{}: {}\n", scene.file.string(), certificate(planned.plan));
  const auto line = [&](const char* what, const std::string& is) {
    text += fmt::format("  {:<10}{}\n", what, is);
  };
  line("model", describe(planned.model(), scene));
  line("method", describe(planned.candidate()));
  line("error", fmt::format("{} {} at most, of every particle and the ends of every body in {} "
                            "frames (the truth's own: {} {})",
                            rounded(planned.best.error), planned.asked.unit,
                            std::ranges::count_if(planned.truth.frames,
                                                  [&](const Snapshot& frame) {
                                                    return frame.time <= planned.truth.horizon;
                                                  }),
                            rounded(planned.asked.per_metre * planned.truth.self_error),
                            planned.asked.unit));
  line("work", times_less(planned.work_as_written, planned.best.work) +
                   fmt::format(" than as it is written ({}, {} {} off)",
                               describe(Candidate{scene.method.name, scene.method.settings}),
                               rounded(planned.error_as_written), planned.asked.unit));
  line("measured",
       fmt::format("{} ms of CPU time per simulated second, {}", rounded(1e3 * planned.cost),
                   times_less(planned.cost_as_written, planned.cost)));
  const Afterwards& after = planned.after;
  line("later", fmt::format("stretch {} at most{}", rounded(after.stretch),
                            after.energy ? fmt::format(", energy within {}% of what can move",
                                                       rounded(100 * *after.energy))
                                         : ""));
  if (after.true_speeds.most > 0) {
    line("", fmt::format("speeds of particles (quartiles, m/s): {} {} {}; of the truth {} {} {}",
                         rounded(after.speeds.low), rounded(after.speeds.median),
                         rounded(after.speeds.high), rounded(after.true_speeds.low),
                         rounded(after.true_speeds.median), rounded(after.true_speeds.high)));
  }
  return text + "\nLeft out:\n" + to_text(left_out(planned));
}

nlohmann::ordered_json as_json(const Planned& planned) {
  nlohmann::ordered_json json = {{"scene", planned.scene.file.string()},
                                 {"tolerance", planned.plan.tolerance},
                                 {"certificate", certificate(planned.plan)},
                                 {"until", planned.plan.until},
                                 {"error", planned.plan.error},
                                 {"method", planned.plan.method.name},
                                 {"settings", settings_json(planned.plan.method.settings)},
                                 {"particles", planned.plan.particles},
                                 {"work", planned.best.work},
                                 {"work_as_written", planned.work_as_written},
                                 {"ms_per_second", 1e3 * planned.cost},
                                 {"ms_per_second_as_written", 1e3 * planned.cost_as_written},
                                 {"error_as_written", planned.error_as_written},
                                 {"stretch", planned.after.stretch},
                                 {"energy", nullptr}};
  if (planned.after.energy) json["energy"] = *planned.after.energy;
  for (const auto& row : left_out(planned).rows) {
    json["left_out"].push_back({{"model", row[0]}, {"method", row[1]}, {"outcome", row[2]}});
  }
  return json;
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
  write_output(common.json ? as_json(planned).dump(2) + "\n" : as_text(planned));
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
