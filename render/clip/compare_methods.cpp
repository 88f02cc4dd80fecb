#include "render/clip/compare_methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "render/base/interrupt.h"
#include "render/program/note.h"
#include "render/program/progress.h"
#include "render/study/study_target.h"
#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"

namespace taut::clips {
namespace {

constexpr double kCpuCap = 60;    // s, of one method's stepping
constexpr double kScored = 1e-3;  // shares of the length: errors from there on are scored

/// The candidate of a contender on this scene: the scene's own settings where they are for it.
MethodChoice candidate_on(const scenes::Scene& scene, const options::Contender& contender) {
  MethodChoice candidate = contender.candidate;
  if (scene.method.name == candidate.name)
    for (const auto& [name, value] : scene.method.settings) candidate.settings.emplace(name, value);
  return candidate;
}

/// The mean distance (m) of the segments in each frame that both have, of the first `most`.
std::vector<double> distances(std::span<const Snapshot> frames, std::span<const Snapshot> from,
                              std::size_t most) {
  std::vector<double> list;
  for (std::size_t k = 0; k < std::min({frames.size(), from.size(), most}); ++k)
    list.push_back(study::segment_difference(frames[k], from[k]));
  return list;
}

/// The mean of distances; not a number where there are fewer than `frames`, or only the start.
double mean(const std::vector<double>& distances, std::size_t frames) {
  if (distances.size() < std::max<std::size_t>(frames, 2)) return NAN;
  return std::reduce(distances.begin(), distances.end()) / double(distances.size());
}

}  // namespace

film::Comparison compare_methods(const scenes::Scene& scene,
                                 const std::vector<options::Contender>& contenders, bool quiet) {
  study::Problem problem{scene.world, {}, scene.timeline};
  for (int k = 0; k < scene.frames(); ++k) problem.times.push_back(double(k) / scene.fps);
  const double length = scene.world.connectors.front().length;
  if (!quiet) program::note("solving the truth\n");
  truth::TruthOptions accuracy;
  if (length > 0) accuracy.scored_error = kScored * length;
  truth::Reference truth = studies::solved_truth(scene, problem.times, accuracy);
  const std::size_t predictable =
      std::size_t(std::ranges::upper_bound(problem.times, truth.horizon) - problem.times.begin());

  program::Progress running("running", "methods", contenders.size(), true);
  std::uint64_t finished = 0;
  const auto run_of = [&](const MethodChoice& candidate) {
    if (!quiet) program::note("running {}\n", describe(candidate));
    study::Run run = study::run(problem, candidate, kCpuCap, render::stop_if_interrupted);
    running.update(++finished);
    return run;
  };
  std::vector<study::Run> runs;
  const study::Run* paper = nullptr;
  for (const options::Contender& contender : contenders) {
    if (contender.method->missing.empty()) {
      runs.push_back(run_of(candidate_on(scene, contender)));
    } else {
      study::Run& missing = runs.emplace_back();
      missing.end = study::Run::End::diverged;
      missing.reason = contender.method->missing;
    }
  }
  // The paper's Figure 6 measures from dynamic constraints.
  const MethodInfo& by_constraints = *find_method(PaperRole::dynamic_constraints);
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (contenders[i].label == by_constraints.name) paper = &runs[i];
  study::Run beside;
  if (!paper && follows(by_constraints, scene.world)) {
    beside = run_of({std::string(by_constraints.name), {}});
  }
  if (!paper) paper = &beside;

  film::Comparison result;
  result.times = problem.times;
  result.truth = std::move(truth.frames);
  result.horizon = truth.horizon;
  result.self_error = truth.self_error;
  const bool by_paper = !paper->frames.empty();
  result.table.columns = {"method"};
  if (by_paper) result.table.columns.push_back("from dynamic constraints, mm");
  for (const char* column :
       {"from the truth, mm", "largest stretch, %", "energy drift, %", "CPU µs per frame"}) {
    result.table.columns.push_back(column);
  }
  result.measured_from = predictable > 1 ? "the truth" : "dynamic constraints";
  const bool closed =
      is_closed(scene.world) && scene.timeline.empty() && energy_scale(scene.world) > 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const study::Run& run = runs[i];
    film::ComparedMethod method{.label = contenders[i].label,
                                .settings = describe(candidate_on(scene, contenders[i]).settings),
                                .style = contenders[i].style,
                                .failure = run.reason,
                                .stretch = run.stretch};
    const auto from_truth = distances(run.frames, result.truth, predictable);
    const auto from_paper = distances(run.frames, paper->frames, problem.times.size());
    method.distance = predictable > 1 ? from_truth : from_paper;
    method.from_constraints = mean(from_paper, problem.times.size());
    method.from_truth = mean(from_truth, predictable);
    if (const double frames = double(run.frames.size()); frames > 0) {
      method.stretch_max = run.stretch_max;
      if (closed) {
        // Contact takes some, and strings where they go taut.
        const bool takes = has_contact(scene.world) || has_strings(scene.world);
        const double lost = takes ? 0 : run.energy_loss;
        method.drift = std::max(run.energy_gain, lost) / energy_scale(scene.world);
      }
      method.cpu = run.cpu / frames;
    }
    std::vector<std::string> row{method.label};
    if (by_paper) row.push_back(options::rounded(1e3 * method.from_constraints));
    for (const double value : {1e3 * method.from_truth, 100 * method.stretch_max,
                               100 * method.drift, 1e6 * method.cpu}) {
      row.push_back(options::rounded(value));
    }
    result.table.add(std::move(row));
    method.frames = run.frames;
    result.methods.push_back(std::move(method));
  }
  return result;
}

}  // namespace taut::clips
