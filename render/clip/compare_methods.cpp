#include "render/clip/compare_methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>
#include <utility>

#include "render/base/interrupt.h"
#include "render/clip/judge.h"
#include "render/program/json.h"
#include "render/program/note.h"
#include "render/program/progress.h"
#include "render/study/study_target.h"
#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"
#include "sim/motion/stop.h"
#include "sim/run/between.h"

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

/// A share of a CPU time's digits: the rest differs from run to run.
double four_digits(double value) {
  if (!(value > 0) || !std::isfinite(value)) return value;
  return std::stod(fmt::format("{:.4g}", value));
}

/// The frames of a run divided into `parts` instants each.
std::vector<Snapshot> instants_of(const study::Problem& problem, const MethodChoice& candidate,
                                  const std::vector<Snapshot>& frames, int parts) {
  if (parts == 1 || frames.size() < 2) return frames;
  const auto start = [&] {
    return Simulation(problem.world, make_method(candidate.name, candidate.settings),
                      problem.timeline);
  };
  Simulation simulation = start();
  std::optional<Between> between(std::in_place, start());
  simulation.advance_to(frames.front().time);
  std::vector<Snapshot> result{frames.front()};
  for (std::size_t f = 1; f < frames.size(); ++f) {
    render::stop_if_interrupted();
    std::vector<double> times;
    const double first = frames[f - 1].time, last = frames[f].time;
    for (int i = 1; i < parts; ++i) times.push_back(std::lerp(first, last, double(i) / parts));
    const World before = std::as_const(simulation).world();
    simulation.advance_to(last);
    std::vector<Snapshot> states;
    try {
      if (between) states = between->states(before, times, frames[f]);
    } catch (const Diverged&) {  // with other steps alone: the last frames stand still between
      between.reset();
    }
    if (states.empty()) states.assign(times.size(), frames[f - 1]);
    std::ranges::move(states, std::back_inserter(result));
    result.push_back(frames[f]);
  }
  return result;
}

/// A row per method. Distances stand there where a truth tells which are those of right methods.
chart::Table table_of(const film::Comparison& comparison, bool by_paper) {
  by_paper &= comparison.by_truth;
  chart::Table table;
  table.columns = {"method"};
  if (by_paper) table.columns.push_back("from dynamic constraints, mm");
  if (comparison.by_truth) table.columns.push_back("from the truth, mm");
  for (const char* column :
       {"largest stretch, %", "energy drift, %", "CPU µs per frame", "verdict"})
    table.columns.push_back(column);
  for (const film::ComparedMethod& method : comparison.methods) {
    std::vector<std::string> row{method.label};
    if (by_paper) row.push_back(options::rounded(1e3 * method.from_constraints));
    if (comparison.by_truth) row.push_back(options::rounded(1e3 * method.from_truth));
    for (const double value : {100 * method.stretch_max, 100 * method.drift, method.cpu_us})
      row.push_back(options::rounded(value));
    row.push_back(method.verdict.text);
    table.add(std::move(row));
  }
  return table;
}

/// What methods are judged by, in a line.
std::string judged_by(const film::Comparison& comparison, const Laws& laws, bool solved) {
  const std::string share = options::percent(film::kKept);
  if (comparison.by_truth) {
    return fmt::format("Right: at most {} of the length from the truth, predictable for {:.3g} s",
                       share, comparison.horizon);
  }
  const std::string kept = words_of(laws);
  const char* why = solved ? "The motion itself is not predictable" : "No truth is known";
  if (kept.empty()) return fmt::format("{}, and no law tells right from wrong", why);
  return fmt::format("Right: {}, within {}. {}", kept, share, why);
}

}  // namespace

CpuTimes cpu_times(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw program::Misuse(fmt::format("--times: {} cannot be read", file.string()));
  const program::Json json = program::Json::parse(in, nullptr, false);
  const auto wrong = [&](const std::string& key) {
    return program::Misuse(
        fmt::format("--times: {}: {} is missing (expected a compare.json)", file.string(), key));
  };
  if (!json.is_object() || !json.contains("methods") || !json["methods"].is_array())
    throw wrong("methods");
  CpuTimes times;
  for (std::size_t i = 0; i < json["methods"].size(); ++i) {
    const program::Json& method = json["methods"][i];
    const auto has = [&](const char* key) { return method.is_object() && method.contains(key); };
    if (!has("method") || !method["method"].is_string())
      throw wrong(fmt::format("methods[{}].method", i));
    if (!has("cpu_us_per_frame") ||
        !(method["cpu_us_per_frame"].is_null() || method["cpu_us_per_frame"].is_number()))
      throw wrong(fmt::format("methods[{}].cpu_us_per_frame", i));
    const program::Json& time = method["cpu_us_per_frame"];
    times[method["method"].get<std::string>()] = time.is_null() ? NAN : time.get<double>();
  }
  return times;
}

film::Comparison compare_methods(const scenes::Scene& scene,
                                 const std::vector<options::Contender>& contenders,
                                 const CompareSettings& settings) {
  const bool quiet = settings.quiet;
  if (settings.times)
    for (const options::Contender& contender : contenders)
      if (!settings.times->contains(contender.label))
        throw program::Misuse("--times: the file has no method " + contender.label);
  study::Problem problem{scene.world, {}, scene.timeline};
  for (int k = 0; k < scene.frames(); ++k) problem.times.push_back(double(k) / scene.fps);
  const double length = scene.world.connectors.front().length;
  if (!quiet) program::note("solving the truth\n");
  truth::TruthOptions accuracy;
  if (length > 0) accuracy.scored_error = kScored * length;
  truth::Reference truth;
  std::string unsolved;
  try {
    truth = studies::solved_truth(scene, problem.times, accuracy);
  } catch (const Diverged& error) {  // as of contact with materials
    unsolved = error.what();
    if (!quiet) program::note("no truth: {}\n", unsolved);
  }
  if (truth.frames.empty())
    truth.frames.push_back(
        Simulation(problem.world, make_method("direct", {}), problem.timeline).state());
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

  const Laws laws = laws_of(scene.world, scene.timeline);
  film::Comparison result;
  result.title = scene.title;
  result.fps = scene.fps;
  result.times = problem.times;
  result.horizon = truth.horizon;
  result.self_error = truth.self_error;
  result.length = length_scale(scene.world);
  result.by_truth = predictable > 1 && 4 * predictable >= problem.times.size() && result.length > 0;
  result.slower = settings.slower.value_or(result.by_truth ? 1 : kSlower);
  result.judged = judged_by(result, laws, unsolved.empty());
  result.loses = laws.loses;
  result.energy_scale = kinetic_energy(scene.world) > film::kKept * laws.energy
                            ? "of weight × length + motion"
                            : "of weight × length";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const study::Run& run = runs[i];
    const MethodChoice candidate = candidate_on(scene, contenders[i]);
    film::ComparedMethod method{.label = contenders[i].label,
                                .settings = describe(candidate.settings),
                                .style = contenders[i].style,
                                .frames = run.frames.size(),
                                .failure = run.reason,
                                .stretch = run.stretch};
    method.distance = distances(run.frames, truth.frames, predictable);
    method.from_constraints =
        mean(distances(run.frames, paper->frames, problem.times.size()), problem.times.size());
    method.from_truth = mean(method.distance, predictable);
    method.verdict =
        result.by_truth ? by_truth(run, method.distance, result.length) : by_laws(run, laws);
    if (laws.energy > 0)
      for (const double energy : run.energy) method.energy.push_back(energy / laws.energy);
    if (const double frames = double(run.frames.size()); frames > 0) {
      method.stretch_max = run.stretch_max;
      if (laws.energy > 0) {
        const double lost = laws.loses ? 0 : run.energy_loss;
        method.drift = std::max(run.energy_gain, lost) / laws.energy;
      }
      method.cpu_us = four_digits(1e6 * run.cpu / frames);
    }
    if (settings.times) method.cpu_us = settings.times->at(method.label);
    method.states = instants_of(problem, candidate, run.frames, result.slower);
    result.methods.push_back(std::move(method));
  }
  result.truth = std::move(truth.frames);
  if (result.slower > 1 && predictable > 1) {
    std::vector<double> times;
    for (std::size_t i = 0; i < result.instants(); ++i) times.push_back(result.time_of(i));
    result.truth = studies::solved_truth(scene, times, accuracy).frames;
  }
  result.result = result_of(result);
  result.table = table_of(result, !paper->frames.empty());
  return result;
}

}  // namespace taut::clips
