#include "render/cli/scoring.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "render/cli/progress.h"
#include "render/interrupt.h"

namespace taut::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kFrontTimings = 10, kTimings = 4, kSlowTimings = 3;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<std::string> cells_of(const AccuracyRow& row) {
  std::vector<std::string> cells{std::to_string(static_cast<int>(row.end)),
                                 row.reason,
                                 exact(row.steps),
                                 exact(row.solves),
                                 exact(row.stretch_max),
                                 exact(row.cpu.empty() ? 0 : row.cpu.front())};
  for (const double error : row.errors) cells.push_back(exact(error));
  return cells;
}

AccuracyRow row_from(const Candidate& candidate, const std::vector<std::string>& cells) {
  AccuracyRow row;
  row.candidate = candidate;
  row.end = static_cast<Run::End>(number_in(cells.at(0)));
  row.reason = cells.at(1);
  row.steps = number_in(cells.at(2));
  row.solves = number_in(cells.at(3));
  row.stretch_max = number_in(cells.at(4));
  if (row.end == Run::End::done) row.cpu = {number_in(cells.at(5))};
  for (std::size_t i = 6; i < cells.size(); ++i) row.errors.push_back(number_in(cells[i]));
  return row;
}

AccuracyRow not_run(const Candidate& candidate, std::size_t metrics) {
  AccuracyRow row;
  row.candidate = candidate;
  row.end = Run::End::over_cap;
  row.reason = "the method's share of the budget was spent";
  row.errors.assign(metrics, std::numeric_limits<double>::infinity());
  return row;
}

/// True for the rows that are on a front by any metric.
std::vector<bool> on_a_front(const AccuracyBlock& block, std::size_t metrics) {
  std::vector<bool> best(block.rows.size());
  for (std::size_t metric = 0; metric < metrics; ++metric) {
    for (const std::size_t i : pareto_front(cost_and_error(block.rows, metric))) best[i] = true;
  }
  return best;
}

}  // namespace

void score_all(AccuracyStudy& study, const Target& target, const std::vector<Metric>& metrics,
               double seconds, bool quick, Journal* journal, bool quiet) {
  std::vector<std::vector<Candidate>> candidates;
  std::size_t total = 0;
  for (const AccuracyBlock& block : study.blocks) {
    candidates.push_back(candidates_of(block.contender, quick));
    total += candidates.back().size();
  }
  Progress progress("scoring", "runs", total, quiet);
  std::size_t done = 0;
  const double share = seconds / static_cast<double>(study.blocks.size());
  for (std::size_t b = 0; b < study.blocks.size(); ++b) {
    const Clock::time_point start = Clock::now();
    for (const Candidate& candidate : candidates[b]) {
      stop_if_interrupted();
      const std::string key = "score " + describe(candidate);
      if (const auto* cells = journal ? journal->find(key) : nullptr) {
        study.blocks[b].rows.push_back(row_from(candidate, *cells));
      } else if (seconds_since(start) > share) {
        study.blocks[b].rows.push_back(not_run(candidate, metrics.size()));
      } else {
        const AccuracyRow row =
            score(target.problem, target.reference, metrics, candidate, share / 4);
        if (journal) journal->add(key, cells_of(row));
        study.blocks[b].rows.push_back(row);
      }
      progress.update(++done);
    }
  }
}

void time_all(AccuracyStudy& study, const Target& target, std::size_t metrics, double seconds,
              double slow) {
  const Clock::time_point start = Clock::now();
  std::vector<std::vector<int>> timings;
  for (const AccuracyBlock& block : study.blocks) timings.emplace_back(block.rows.size());
  for (int round = 0; round < kFrontTimings; ++round) {
    for (std::size_t b = 0; b < study.blocks.size(); ++b) {
      AccuracyBlock& block = study.blocks[b];
      const std::vector<bool> best = on_a_front(block, metrics);
      for (std::size_t i = 0; i < block.rows.size(); ++i) {
        AccuracyRow& row = block.rows[i];
        stop_if_interrupted();
        if (seconds_since(start) > seconds) return;
        if (row.cpu.empty() || (!best[i] && (round < kTimings || timings[b][i] == kTimings)))
          continue;
        const bool is_slow = row.cpu.front() * target.problem.duration() > slow;
        if (is_slow && timings[b][i] >= kSlowTimings) continue;
        if (timings[b][i]++ == 0) row.cpu.clear();  // states were recorded between its steps
        add_timing(target.problem, row);
      }
    }
  }
}

}  // namespace taut::cli
