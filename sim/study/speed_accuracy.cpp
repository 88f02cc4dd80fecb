#include "sim/study/speed_accuracy.h"

#include <algorithm>
#include <limits>

namespace taut::study {

AccuracyRow score(const Problem& problem, const truth::Reference& reference,
                  std::span<const Metric> metrics, const MethodChoice& candidate, double cpu_cap,
                  const std::function<void()>& tick) {
  const Run result = run(problem, candidate, cpu_cap, tick);
  AccuracyRow row{.candidate = candidate,
                  .end = result.end,
                  .reason = result.reason,
                  .errors = {},
                  .cpu = {},
                  .stretch_max = result.stretch_max,
                  .penetration_max = result.penetration_max,
                  .energy_gain = result.energy_gain};
  for (const Metric& metric : metrics) {
    row.errors.push_back(
        result.end == Run::End::done
            ? rms_error(result.frames, reference.frames, reference.horizon, metric.distance)
            : std::numeric_limits<double>::infinity());
  }
  if (result.end != Run::End::done) return row;
  row.steps = static_cast<double>(result.counters.steps) / problem.duration();
  row.solves = static_cast<double>(result.counters.solves) / problem.duration();
  row.cpu = {result.cpu / problem.duration()};
  // Looking at states between the steps disturbs a brief run by more than it takes.
  constexpr double kBrief = 0.05;  // s
  if (result.cpu >= kBrief) return row;
  try {
    row.cpu = {time_run(problem, candidate) / problem.duration()};
  } catch (const Diverged& error) {
    // An engine need not do the same twice.
    row.end = Run::End::diverged;
    row.reason = error.what();
    row.cpu.clear();
    row.errors.assign(metrics.size(), std::numeric_limits<double>::infinity());
  }
  return row;
}

void add_timing(const Problem& problem, AccuracyRow& row) {
  if (row.end != Run::End::done) return;
  row.cpu.push_back(time_run(problem, row.candidate) / problem.duration());
}

double unsteadiness(std::span<const AccuracyRow> rows) {
  std::vector<double> shares;
  for (const AccuracyRow& row : rows) {
    if (row.cpu.size() < 3) continue;
    const Spread time = spread(row.cpu);
    shares.push_back(std::max(time.most - time.median, time.median - time.least) / time.median);
  }
  return spread(std::move(shares)).median;
}

std::vector<CostAndError> cost_and_error(std::span<const AccuracyRow> rows, std::size_t metric) {
  std::vector<CostAndError> points;
  for (const AccuracyRow& row : rows) {
    points.push_back({row.end == Run::End::done ? spread(row.cpu).median
                                                : std::numeric_limits<double>::infinity(),
                      row.errors[metric]});
  }
  return points;
}

}  // namespace taut::study
