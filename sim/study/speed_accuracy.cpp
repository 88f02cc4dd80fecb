#include "sim/study/speed_accuracy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace taut::study {

std::vector<std::size_t> pareto_front(std::span<const CostAndError> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return points[a].cost != points[b].cost ? points[a].cost < points[b].cost
                                            : points[a].error < points[b].error;
  });
  std::vector<std::size_t> front;
  double best = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order) {
    if (!(points[i].error < best)) continue;
    best = points[i].error;
    front.push_back(i);
  }
  return front;
}

std::optional<std::size_t> cheapest(std::span<const CostAndError> points, double error) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(points[i].error <= error)) continue;
    if (!found || points[i].cost < points[*found].cost) found = i;
  }
  return found;
}

std::optional<double> cost_at(std::span<const CostAndError> points, double error) {
  const std::vector<std::size_t> front = pareto_front(points);
  for (std::size_t i = 0; i < front.size(); ++i) {
    const CostAndError& fine = points[front[i]];
    if (fine.error > error) continue;
    if (i == 0 || fine.error == error) return fine.cost;
    const CostAndError& coarse = points[front[i - 1]];
    const double share = std::log(coarse.error / error) / std::log(coarse.error / fine.error);
    return coarse.cost * std::pow(fine.cost / coarse.cost, share);
  }
  return std::nullopt;
}

Spread spread(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const auto quantile = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - std::floor(place)) * (values[above] - values[below]);
  };
  return {values.front(), quantile(0.25), quantile(0.5), quantile(0.75), values.back()};
}

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
