#include "render/study/scoring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "render/base/child.h"
#include "render/base/interrupt.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "sim/evaluation/run.h"

namespace taut::studies {
namespace {

constexpr int kFrontTimings = 10, kTimings = 4, kSlowTimings = 3;

std::string list_of(const std::vector<double>& numbers) {
  std::string list;
  for (const double number : numbers) list += (list.empty() ? "" : " ") + program::exact(number);
  return list;
}

std::vector<double> numbers_in(const std::string& list) {
  std::istringstream in(list);
  std::vector<double> numbers;
  for (std::string word; in >> word;) numbers.push_back(program::number_in(word));
  return numbers;
}

std::vector<std::string> cells_of(const study::AccuracyRow& row) {
  std::vector<std::string> cells{std::to_string(static_cast<int>(row.end)),
                                 row.reason,
                                 program::exact(row.steps),
                                 program::exact(row.solves),
                                 program::exact(row.stretch_max),
                                 program::exact(row.penetration_max),
                                 program::exact(row.energy_gain),
                                 list_of(row.cpu)};
  for (const double error : row.errors) cells.push_back(program::exact(error));
  return cells;
}

study::AccuracyRow not_run(const MethodChoice& candidate, std::size_t metrics) {
  study::AccuracyRow row;
  row.candidate = candidate;
  row.end = study::Run::End::over_cap;
  row.reason = "the method's share of the budget was spent";
  row.errors.assign(metrics, std::numeric_limits<double>::infinity());
  return row;
}

/// True for the rows that are on a front by any metric.
std::vector<bool> on_a_front(const AccuracyBlock& block, std::size_t metrics) {
  std::vector<bool> best(block.rows.size());
  for (std::size_t metric = 0; metric < metrics; ++metric) {
    for (const std::size_t i : study::pareto_front(study::cost_and_error(block.rows, metric)))
      best[i] = true;
  }
  return best;
}

}  // namespace

study::AccuracyRow row_from(const MethodChoice& candidate, const std::vector<std::string>& cells) {
  study::AccuracyRow row;
  row.candidate = candidate;
  row.end = static_cast<study::Run::End>(program::number_in(cells.at(0)));
  row.reason = cells.at(1);
  row.steps = program::number_in(cells.at(2));
  row.solves = program::number_in(cells.at(3));
  row.stretch_max = program::number_in(cells.at(4));
  row.penetration_max = program::number_in(cells.at(5));
  row.energy_gain = program::number_in(cells.at(6));
  row.cpu = numbers_in(cells.at(7));
  for (std::size_t i = 8; i < cells.size(); ++i) row.errors.push_back(program::number_in(cells[i]));
  return row;
}

std::string score_key(const MethodChoice& candidate) {
  return "score " + describe(candidate);
}

std::vector<MethodChoice> all_candidates(const AccuracyStudy& study, bool quick) {
  std::vector<MethodChoice> all;
  for (const AccuracyBlock& block : study.blocks) {
    for (MethodChoice& candidate : options::candidates_of(block.contender, quick)) {
      all.push_back(std::move(candidate));
    }
  }
  return all;
}

double cap_of_a_run(const AccuracyStudy& study, double seconds) {
  return seconds / static_cast<double>(study.blocks.size()) / 4;
}

std::vector<std::string> scored_and_timed(const Target& target,
                                          const std::vector<study::Metric>& metrics,
                                          const MethodChoice& candidate, double cap, double slow) {
  study::AccuracyRow row = study::score(target.problem, target.reference, metrics, candidate, cap);
  if (!row.cpu.empty()) {
    const bool is_slow = row.cpu.front() * target.problem.duration() > slow;
    row.cpu.clear();  // states were recorded between its steps
    for (int i = 0; i < (is_slow ? kSlowTimings : kTimings); ++i) {
      render::stop_if_interrupted();
      study::add_timing(target.problem, row);
    }
  }
  return cells_of(row);
}

void score_all(AccuracyStudy& study, const Target& target,
               const std::vector<study::Metric>& metrics, double seconds, bool quick,
               program::Journal* journal, bool quiet) {
  std::vector<std::vector<MethodChoice>> candidates;
  std::size_t total = 0;
  for (const AccuracyBlock& block : study.blocks) {
    candidates.push_back(options::candidates_of(block.contender, quick));
    total += candidates.back().size();
  }
  program::Progress progress("scoring", "runs", total, quiet);
  std::size_t done = 0;
  const double share = seconds / static_cast<double>(study.blocks.size());
  for (std::size_t b = 0; b < study.blocks.size(); ++b) {
    const double start = render::process_seconds();
    for (const MethodChoice& candidate : candidates[b]) {
      render::stop_if_interrupted();
      const std::string key = score_key(candidate);
      if (const auto* cells = journal ? journal->find(key) : nullptr) {
        study.blocks[b].rows.push_back(row_from(candidate, *cells));
      } else if (render::process_seconds() - start > share) {
        study.blocks[b].rows.push_back(not_run(candidate, metrics.size()));
      } else {
        const study::AccuracyRow row = study::score(target.problem, target.reference, metrics,
                                                    candidate, cap_of_a_run(study, seconds));
        if (journal) journal->add(key, cells_of(row));
        study.blocks[b].rows.push_back(row);
      }
      progress.update(++done);
    }
  }
}

void time_all(AccuracyStudy& study, const Target& target, std::size_t metrics, double seconds,
              double slow) {
  const double start = render::process_seconds();
  std::vector<std::vector<int>> timings;
  for (const AccuracyBlock& block : study.blocks) timings.emplace_back(block.rows.size());
  for (int round = 0; round < kFrontTimings; ++round) {
    for (std::size_t b = 0; b < study.blocks.size(); ++b) {
      AccuracyBlock& block = study.blocks[b];
      const std::vector<bool> best = on_a_front(block, metrics);
      for (std::size_t i = 0; i < block.rows.size(); ++i) {
        study::AccuracyRow& row = block.rows[i];
        render::stop_if_interrupted();
        if (render::process_seconds() - start > seconds) return;
        if (row.cpu.empty() || (!best[i] && (round < kTimings || timings[b][i] == kTimings)))
          continue;
        const bool is_slow = row.cpu.front() * target.problem.duration() > slow;
        if (is_slow && timings[b][i] >= kSlowTimings) continue;
        if (timings[b][i]++ == 0) row.cpu.clear();  // states were recorded between its steps
        study::add_timing(target.problem, row);
      }
    }
  }
}

namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity.
Json finite(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

/// Why there is no finite estimate, or empty.
std::string reason(const ErrorEstimate& estimate) {
  if (!estimate.none().empty()) return estimate.none();
  if (estimate.diverged().empty()) return {};
  return "the run beside it ended: " + estimate.diverged();
}

}  // namespace

const std::string_view kEstimateHelp =
    "The run estimates its own error: a second run of the method with other settings (direct: "
    "steps\n"
    "shorter by a fifth; others: tolerance times 4, or twice the step) gives a difference, and\n"
    "Richardson's extrapolation the error from it, as an RMS of all particles, in m. The motion "
    "is\n"
    "predictable until the estimate exceeds the tolerance asked for or, if the method has none in\n"
    "metres, a hundredth of the longest connector. --no-estimate saves the time of the second run.";

SelfEstimate::SelfEstimate(const scenes::Scene& scene, bool on) {
  if (on) estimate_.emplace(scene.world, scene.method.name, scene.method.settings, scene.timeline);
}

void SelfEstimate::follow(const Simulation& simulation) {
  if (!exists()) return;
  const double before = thread_seconds();
  estimate_->follow(simulation);
  seconds_ += thread_seconds() - before;
  until_ = simulation.world().time;
}

double SelfEstimate::error() const {
  return estimate_.value().error();
}

void SelfEstimate::add_to(nlohmann::ordered_json& record) const {
  if (!estimate_) return;
  const std::string why = reason(*estimate_);
  const auto until = estimate_->predictable_until();
  record["error_estimate_m"] = {{"largest", finite(estimate_->largest())},
                                {"final", finite(estimate_->error())}};
  record["error_estimate_reason"] = why.empty() ? Json(nullptr) : Json(why);
  record["predictable_until_s"] = until ? Json(*until) : Json(nullptr);
  record["predictable_until_is"] = fmt::format(
      "the first time at which the estimate exceeds {} m; null where it never does, or where there "
      "is no estimate",
      estimate_->limit());
  record["foretold_until_s"] = record["predictable_until_s"];  // its former name
  record["estimate_ms_per_second"] = until_ > 0 ? Json(1e3 * seconds_ / until_) : Json(nullptr);
}

std::string SelfEstimate::line() const {
  if (!estimate_) return {};
  const std::string why = reason(*estimate_);
  if (!estimate_->none().empty()) return "error estimate: none, as " + why + "\n";
  const auto until = estimate_->predictable_until();
  return fmt::format(
      "error estimate: {:.3g} m at most, {}{}\n", estimate_->largest(),
      until ? fmt::format("above {:.3g} m from {:.4g} s on", estimate_->limit(), *until)
            : fmt::format("never above {:.3g} m", estimate_->limit()),
      why.empty() ? "" : "; " + why);
}

namespace {

constexpr double kTargets[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};  // shares of the length

void find_unsteadiness(AccuracyStudy& study) {
  std::vector<study::AccuracyRow> rows;
  for (const AccuracyBlock& block : study.blocks) {
    rows.insert(rows.end(), block.rows.begin(), block.rows.end());
  }
  study.unsteadiness = study::unsteadiness(rows);
}

}  // namespace

double scored_length(const scenes::Scene& scene) {
  const double length = scene.world.connectors.front().length;
  if (!(length > 0)) throw program::Misuse("a joint has no length to measure errors by");
  return length;
}

double least_share(bool quick) {
  return quick ? 1e-4 : 1e-6;
}

Target scored_target(const scenes::Scene& scene, double share) {
  truth::TruthOptions truth;
  truth.scored_error = scored_length(scene) * share;
  if (share >= least_share(true)) truth.second_accuracy = 1e-7;
  return predictable_target(scene, truth);
}

std::vector<study::Metric> accuracy_metrics(const scenes::Scene& scene) {
  std::vector<study::Metric> metrics{study::share_of_length(scored_length(scene))};
  if (const auto pixels = pixels_of(scene)) metrics.push_back(*pixels);
  return metrics;
}

AccuracyStudy accuracy_study(const options::StudyOptions& options, const scenes::Scene& scene) {
  AccuracyStudy study;
  study.scene = options.scene;
  study.title = scene.title;
  study.set = options.inputs.set;
  study.share = least_share(options.quick);
  study.particles = scene.world.connectors.front().particles();
  study.targets.assign(std::begin(kTargets), std::end(kTargets));
  study.in_pixels = pixels_of(scene).has_value();
  for (const options::Contender& contender : options::contenders_on(options, scene.world)) {
    study.blocks.push_back({contender, {}});
  }
  return study;
}

void measure(AccuracyStudy& study, const Target& target, const std::vector<study::Metric>& metrics,
             double budget, bool quick, program::Journal* journal, bool quiet) {
  score_all(study, target, metrics, kScoring * budget, quick, journal, quiet);
  time_all(study, target, metrics.size(), kTiming * budget, kSlow * budget);
  find_unsteadiness(study);
}

void merge_rows(AccuracyStudy& study, const std::vector<study::Metric>& metrics, bool quick,
                program::Journal& journal) {
  constexpr double kNoTime = 1;  // s; nothing is run
  score_all(study, {}, metrics, kNoTime, quick, &journal, true);
  find_unsteadiness(study);
}

}  // namespace taut::studies
