// Error against cost, one row per candidate.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/truth/truth.h"

namespace taut::study {

// Cost against error: which settings are worth their price.

struct CostAndError {
  double cost = 0;   // CPU seconds per simulated second
  double error = 0;  // not finite: the run gave none
};

/// The points that no other beats in both, by rising cost.
std::vector<std::size_t> pareto_front(std::span<const CostAndError> points);

/// The cheapest point whose error is at most `error`.
std::optional<std::size_t> cheapest(std::span<const CostAndError> points, double error);

/// The cost of an error of `error` along the front: between the two points on either side of it, on
/// a straight line of their logarithms. Where even the cheapest is nearer: its cost. None where the
/// front does not reach it.
std::optional<double> cost_at(std::span<const CostAndError> points, double error);

/// Median of `values`, the quartiles around it and the ends; zero where there are none.
struct Spread {
  double least = 0, low = 0, median = 0, high = 0, most = 0;
};
Spread spread(std::vector<double> values);

struct AccuracyRow {
  MethodChoice candidate;
  Run::End end = Run::End::done;
  std::string reason;            // of an end that is not `done`
  std::vector<double> errors;    // one per metric; infinite where the run did not reach the horizon
  std::vector<double> cpu;       // s per simulated second, one per timing
  double steps = 0, solves = 0;  // per simulated second
  double stretch_max = 0;
  double penetration_max = 0;  // m
  double energy_gain = 0;      // J, the most above the energy at the start
};

/// Runs a candidate once, as run() does, and scores it against the reference. Runs that end early
/// have no timings.
AccuracyRow score(const Problem& problem, const truth::Reference& reference,
                  std::span<const Metric> metrics, const MethodChoice& candidate, double cpu_cap,
                  const std::function<void()>& tick = {});

/// Adds one timing to a row whose run was done.
void add_timing(const Problem& problem, AccuracyRow& row);

/// How steady the machine was: the median, over all rows timed three times or more, of the largest
/// distance of a timing from the row's median, as a share of that. Zero where there is no such row.
double unsteadiness(std::span<const AccuracyRow> rows);

/// Median cost and error of every row under one metric.
std::vector<CostAndError> cost_and_error(std::span<const AccuracyRow> rows, std::size_t metric);

}  // namespace taut::study
