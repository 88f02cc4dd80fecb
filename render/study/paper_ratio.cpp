#include "render/study/paper_ratio.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "render/base/interrupt.h"
#include "render/study/study_target.h"
#include "sim/study/speed_accuracy.h"

namespace taut::studies {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kPaper = "impulse";
constexpr const char* kParticleSystem = "springs";
constexpr double kBorne = 0.9;  // of the stability limit, by the springs' steps
constexpr int kRepeats = 5;

const options::Contender* named(const std::vector<options::Contender>& contenders,
                                std::string_view label) {
  const auto found = std::ranges::find(contenders, label, &options::Contender::label);
  return found == contenders.end() ? nullptr : &*found;
}

/// A candidate's cost (CPU s per simulated second), the median of a few runs in a row.
double cost_of(const study::Problem& problem, const study::Candidate& candidate) {
  std::vector<double> costs;
  for (int i = 0; i < kRepeats; ++i) {
    render::stop_if_interrupted();
    costs.push_back(study::time_run(problem, candidate) / problem.duration());
  }
  return study::spread(std::move(costs)).median;
}

/// Springs at `substeps` equal steps a frame, as hard as these bear by the theory of a chain at
/// rest: the longest stable step falls with the root of the stiffness.
study::Candidate hardest(const options::Contender& springs, const World& world, double frame,
                         double substeps) {
  const Settings soft = with_defaults(*springs.method, {{"stiffness", 1.0}});
  const double step = frame / substeps;
  const double stiffness = std::pow(kBorne * springs.method->longest_step(world, soft) / step, 2);
  return {kParticleSystem, {{"step", step}, {"stiffness", stiffness}}};
}

study::AccuracyRow scored(const Target& target, double length, const study::Candidate& candidate) {
  const study::Metric metric = study::share_of_length(length);
  return study::score(target.problem, target.reference, std::span(&metric, 1), candidate, 60);
}

PaperSetting setting_at(const Target& target, const scenes::Scene& scene,
                        const options::Contender& springs, const study::Candidate& impulse,
                        double impulse_steps) {
  const Connector& rope = scene.world.connectors.front();
  const double frame = 1.0 / scene.fps;
  PaperSetting found;
  found.particles = rope.particles();
  found.impulse_steps = impulse_steps;
  found.impulse_cost = cost_of(target.problem, impulse) * frame;
  found.impulse_error = scored(target, rope.length, impulse).errors[0];
  const double asked = kPaperRatio * found.impulse_cost;
  const auto cost = [&](double substeps) {
    return cost_of(target.problem, hardest(springs, scene.world, frame, substeps)) * frame;
  };
  // The cost of a frame is linear in its steps: find where it is, then once more from nearby.
  found.substeps = 16;
  for (int i = 0; i < 3; ++i) {
    found.substeps =
        std::clamp(std::round(found.substeps * asked / cost(found.substeps)), 1.0, 1e5);
  }
  const study::Candidate equal = hardest(springs, scene.world, frame, found.substeps);
  found.stiffness = number(equal.settings, "stiffness");
  found.ratio = cost(found.substeps) / found.impulse_cost;
  const study::AccuracyRow row = scored(target, rope.length, equal);
  found.error = row.errors[0];
  found.stretch = row.stretch_max;
  return found;
}

/// Every contender's runs, cheap ones first, until its share of `seconds` is spent.
std::vector<std::vector<study::AccuracyRow>> runs_of(
    const Target& target, double length, const std::vector<options::Contender>& contenders,
    double seconds, bool quick) {
  std::vector<std::vector<study::AccuracyRow>> all;
  const double share = seconds / static_cast<double>(contenders.size());
  const study::Metric metric = study::share_of_length(length);
  for (const options::Contender& one : contenders) {
    const Clock::time_point start = Clock::now();
    std::vector<study::AccuracyRow> rows;
    for (const study::Candidate& candidate : options::candidates_of(one, quick)) {
      render::stop_if_interrupted();
      const double spent = std::chrono::duration<double>(Clock::now() - start).count();
      if (spent > share) break;
      rows.push_back(study::score(target.problem, target.reference, std::span(&metric, 1),
                                  candidate, (share - spent) / 2));
      if (spent < share / 2) study::add_timing(target.problem, rows.back());
    }
    all.push_back(std::move(rows));
  }
  return all;
}

}  // namespace

PaperRatio paper_ratio(const options::StudyOptions& options,
                       const std::vector<options::Contender>& contenders, std::size_t particles,
                       double duration, double seconds) {
  const options::Contender* impulse = named(contenders, kPaper);
  const options::Contender* springs = named(contenders, kParticleSystem);
  PaperRatio result;
  if (!impulse || !springs) return result;
  const scenes::Scene scene = options::study_scene(options, particles);
  // The paper's method follows none of these.
  if (has_contact(scene.world) || has_materials(scene.world)) return result;
  if (!scene.world.joints.empty() || has_strings(scene.world)) return result;
  const double length = scene.world.connectors.front().length;
  truth::TruthOptions truth;  // errors of a hundredth of the length are asked for, and not less
  truth.scored_error = 0.01 * length;
  truth.local_error = 1e-9;
  truth.second_accuracy = 1e-5;
  const Target target = target_of(scene, duration, truth);
  if (target.problem.times.size() < 2) return result;
  result.horizon = target.reference.horizon;

  const double step = 1.0 / scene.fps;
  result.settings.push_back(setting_at(target, scene, *springs, {kPaper, {{"step", step}}}, 1));
  const double fallback = number(with_defaults(*impulse->method, {}), "step");
  result.settings.push_back(setting_at(target, scene, *springs, {kPaper, {}},
                                       static_cast<double>(step_count(step, fallback))));

  const auto runs = runs_of(target, length, contenders, seconds, options.quick);
  const auto points =
      study::cost_and_error(runs[static_cast<std::size_t>(impulse - contenders.data())], 0);
  const std::vector<std::size_t> front = study::pareto_front(points);
  if (front.empty()) return result;
  for (const std::size_t at : {front.front(), front.back()}) {
    for (std::size_t c = 0; c < contenders.size(); ++c) {
      if (&contenders[c] == impulse) continue;
      const auto cost = study::cost_at(study::cost_and_error(runs[c], 0), points[at].error);
      result.equal.push_back(
          {particles, points[at].error, contenders[c].label, points[at].cost, cost.value_or(0)});
    }
    if (front.size() == 1) break;
  }
  return result;
}

chart::Table settings_table(const std::vector<PaperRatio>& all) {
  chart::Table table{
      {"particles", "impulse: steps per frame", "impulse: error (share of length)",
       "springs: steps per frame", "springs: stiffness (N/m)", "springs: error (share of length)",
       "springs: largest stretch", "springs / impulse"},
      {}};
  for (const PaperRatio& one : all) {
    for (const PaperSetting& s : one.settings) {
      table.add({std::to_string(s.particles), options::rounded(s.impulse_steps),
                 options::rounded(s.impulse_error), options::rounded(s.substeps),
                 options::rounded(s.stiffness), options::rounded(s.error),
                 options::rounded(s.stretch), options::rounded(s.ratio)});
    }
  }
  return table;
}

chart::Table equal_error_table(const std::vector<PaperRatio>& all) {
  chart::Table table{{"particles", "error (share of length)", "method", "impulse: ms per second",
                      "method: ms per second", "method / impulse"},
                     {}};
  for (const PaperRatio& one : all) {
    for (const EqualError& e : one.equal) {
      const bool known = e.cost > 0;
      table.add({std::to_string(e.particles), options::rounded(e.error), e.method,
                 options::rounded(1e3 * e.impulse_cost),
                 known ? options::rounded(1e3 * e.cost) : "-",
                 known ? options::rounded(e.cost / e.impulse_cost) : "-"});
    }
  }
  return table;
}

}  // namespace taut::studies
