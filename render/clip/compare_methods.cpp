#include "render/clip/compare_methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>
#include <utility>

#include "render/base/interrupt.h"
#include "render/program/output.h"
#include "render/study/study_target.h"
#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"
#include "sim/motion/stop.h"
#include "sim/run/simulation.h"
#include "sim/world/held.h"

namespace taut::clips {
namespace {

using Grade = film::Verdict::Grade;

constexpr double kBroken = 10;  // times film::kKept

std::string percent(double share) {
  const double value = 100 * share;
  if (value < 9.95) return fmt::format("{:.2g}%", value);
  return value < 1e5 ? fmt::format("{:.0f}%", value) : fmt::format("{:.0e}%", value);
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 < parts.size() ? ", " : " and ") + parts[i];
  return text;
}

bool is_held(const World& world) {
  return std::ranges::any_of(world.bodies, &Body::driven) ||
         std::ranges::any_of(world.connectors, [&](const Connector& connector) {
           return std::ranges::any_of(
               connector.holds, [&](const Hold& hold) { return is_prescribed(world, hold.to); });
         });
}

Grade grade_of(double times_kept) {
  return times_kept <= 1 ? Grade::kept : times_kept <= kBroken ? Grade::off : Grade::broken;
}

/// The verdict on a run that ended early.
film::Verdict stopped(const study::Run& run) {
  film::Verdict verdict{.grade = Grade::broken};
  if (run.frames.empty()) {
    verdict.text = "does not run";
  } else {
    verdict.text = fmt::format("stops after {:.2g} s", run.reached);
    verdict.worst = run.frames.size() - 1;
  }
  return verdict;
}

}  // namespace

Laws laws_of(const World& world, const Timeline& timeline) {
  Laws laws;
  if (is_closed(world) && timeline.empty()) laws.energy = std::max(energy_scale(world), 0.0);
  laws.loses = has_contact(world) || has_strings(world) ||
               std::ranges::any_of(world.connectors, [](const Connector& connector) {
                 return connector.model == ConnectorModel::span;
               });
  if (laws.energy > 0 && !has_contact(world) && !is_held(world))
    laws.momentum = std::sqrt(2 * laws.energy * moving_mass(world));
  laws.length = std::ranges::none_of(world.connectors, &Connector::stretches);
  return laws;
}

std::string words_of(const Laws& laws) {
  std::vector<std::string> kept;
  if (laws.energy > 0 && !laws.loses) kept.push_back("energy");
  if (laws.length) kept.push_back("length");
  if (laws.momentum > 0) kept.push_back("momentum");
  std::vector<std::string> words;
  if (laws.energy > 0 && laws.loses) words.push_back("gains no energy");
  if (!kept.empty()) words.push_back("keeps " + joined(kept));
  return joined(words);
}

film::Verdict by_laws(const study::Run& run, const Laws& laws) {
  if (run.end != study::Run::End::done) return stopped(run);
  film::Verdict verdict;
  double worst = -1, gain = 0, loss = 0, stretch = 0, momentum = 0;
  for (std::size_t k = 0; k < run.frames.size(); ++k) {
    const double energy = laws.energy > 0 ? run.energy[k] / laws.energy : 0;
    const double gained = std::max(energy, 0.0), lost = laws.loses ? 0 : std::max(-energy, 0.0);
    const double longer = laws.length ? run.stretch[k] : 0;
    const double pushed = laws.momentum > 0 ? run.momentum[k] / laws.momentum : 0;
    gain = std::max(gain, gained);
    loss = std::max(loss, lost);
    stretch = std::max(stretch, longer);
    momentum = std::max(momentum, pushed);
    if (const double off = std::max({gained, lost, longer, pushed}); off > worst) {
      worst = off;
      verdict.worst = k;
    }
  }
  const std::string kept = words_of(laws);
  if (kept.empty()) {
    verdict.text = "no law to judge it by";
    return verdict;
  }
  verdict.grade = grade_of(worst / film::kKept);
  std::vector<std::string> broken;
  if (gain > film::kKept && gain >= loss)
    broken.push_back(fmt::format("gains {} energy", percent(gain)));
  else if (loss > film::kKept)
    broken.push_back(fmt::format("loses {} energy", percent(loss)));
  if (stretch > film::kKept) broken.push_back(fmt::format("stretches by {}", percent(stretch)));
  if (momentum > film::kKept) broken.push_back(fmt::format("gains {} momentum", percent(momentum)));
  verdict.text = broken.empty() ? kept : joined(broken);
  return verdict;
}

film::Verdict by_truth(const study::Run& run, const std::vector<double>& distances, double length) {
  if (run.end != study::Run::End::done) return stopped(run);
  film::Verdict verdict;
  const auto worst = std::ranges::max_element(distances);
  const double most = worst == distances.end() ? 0 : *worst;
  verdict.worst = std::size_t(worst - distances.begin());
  verdict.grade = grade_of(most / (film::kKept * length));
  const double mm = 1e3 * most;
  std::string size = fmt::format("{:.0f} mm", mm);
  if (verdict.grade == Grade::kept) {  // "within" is rounded up, to one digit
    const double digit = std::pow(10, std::floor(std::log10(std::max(mm, 1e-4))));
    size = fmt::format("{:g} mm", std::max(std::ceil(mm / digit - 1e-9) * digit, 1e-3));
  } else if (mm < 9.95) {
    size = fmt::format("{:.2g} mm", mm);
  } else if (mm >= 1e3) {
    size = fmt::format("{:.3g} m", most);
  }
  verdict.text = verdict.grade == Grade::kept ? fmt::format("within {} of the truth", size)
                                              : fmt::format("{} from the truth", size);
  return verdict;
}

std::string duration_text(double seconds) {
  const auto two = [](double value) {
    return value < 9.95 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value);
  };
  if (seconds < 0.995e-5) return two(1e6 * seconds) + " µs";
  if (seconds < 0.9995) return two(1e3 * seconds) + " ms";
  return two(seconds) + " s";
}

std::vector<std::string> result_of(const film::Comparison& comparison) {
  std::vector<const film::ComparedMethod*> order;
  for (const film::ComparedMethod& method : comparison.methods) order.push_back(&method);
  const auto rank = [](const film::ComparedMethod* method) {
    const Grade grade = method->verdict.grade;
    return grade == Grade::kept ? 0 : grade == Grade::none ? 1 : grade == Grade::off ? 2 : 3;
  };
  std::ranges::stable_sort(order, [&](const auto* a, const auto* b) {
    return rank(a) != rank(b) ? rank(a) < rank(b) : rank(a) < 2 && a->cpu_us < b->cpu_us;
  });
  std::vector<std::string> clauses;
  for (const film::ComparedMethod* method : order) {
    const Grade grade = method->verdict.grade;
    const bool plain = comparison.by_truth && !method->verdict.text.starts_with("stops") &&
                       !method->verdict.text.starts_with("does");
    std::string clause = method->label +
                         (plain                  ? " is "
                          : grade == Grade::none ? ": "
                                                 : " ") +
                         method->verdict.text;
    if (std::isfinite(method->cpu_us))
      clause +=
          fmt::format(", for {} a second", duration_text(1e-6 * method->cpu_us * comparison.fps));
    clauses.push_back(std::move(clause));
  }
  return clauses;
}

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
