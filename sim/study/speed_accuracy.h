// Error against cost, one row per candidate; the cost of each frame (the paper's Figure 5); and the
// paper's ratio of costs, 2.76.
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

// The cost of each frame for each candidate: the paper's Figure 5.

struct BenchRow {
  MethodChoice candidate;
  std::string failure;         // why it has no timings, or not of every frame
  std::vector<Spread> frames;  // s of CPU time per frame, over the repeats
  Spread mean;                 // s per frame: the mean of a repeat's frames, over the repeats
  double steps = 0;            // per frame
  std::size_t repeats = 0;
};

struct BenchOptions {
  std::size_t repeats = 15;     // at most
  double seconds = 10;          // of each candidate's stepping, after which it is repeated no more
  std::function<void()> pause;  // called between runs; may throw to stop
};

/// Times every frame of `problem` (its first time is where it starts) for every candidate.
/// Candidates take turns, one run each in every repeat, so that a disturbance of the machine meets
/// them all. Nothing but the stepping lies within the timed region.
std::vector<BenchRow> bench(const Problem& problem, std::span<const MethodChoice> candidates,
                            const BenchOptions& options);

// The paper's one number on cost, "2.76 times faster than the particle system": under which
// settings it appears, and what it is at equal error.

inline constexpr double kPaperRatio = 2.76;  // the particle system's time over the paper's method's

/// A particle system that costs kPaperRatio times as much as the paper's method.
struct PaperSetting {
  std::size_t particles = 0;
  double impulse_steps = 0;       // per frame
  double impulse_cost = 0;        // CPU s per frame
  double impulse_error = 0;       // RMS, share of the length
  double substeps = 0;            // of the springs, per frame
  double stiffness = 0;           // N/m, the hardest that these steps bear
  double ratio = 0;               // as measured
  double error = 0, stretch = 0;  // of the springs; shares of the length and of a link
};

/// The cost of a method where its error equals the paper's method's at one of its own settings.
struct EqualError {
  std::size_t particles = 0;
  double error = 0;         // RMS, share of the length
  std::string method;       // entrant's label
  double impulse_cost = 0;  // CPU s per simulated second
  double cost = 0;          // the same of `method`, between its two nearest settings or, where all
                            // are nearer to the truth, of the cheapest; 0: not reached
};

struct PaperRatio {
  double horizon = 0;  // s, of the errors
  std::vector<PaperSetting> settings;
  std::vector<EqualError> equal;
};

/// A method or a form of it, and the settings that are tried, cheap to dear.
struct Entrant {
  std::string label;
  const MethodInfo* method = nullptr;
  std::vector<MethodChoice> candidates;
};

/// Measures both on a problem of frames of `frame` (s) up to the reference's horizon. `seconds`:
/// about how long it may take. Empty where the entrants lack one of the two methods. Calls `tick`
/// between runs; it may throw to stop.
PaperRatio paper_ratio(const Problem& problem, const truth::Reference& reference, double frame,
                       std::span<const Entrant> entrants, double seconds,
                       const std::function<void()>& tick);

}  // namespace taut::study
