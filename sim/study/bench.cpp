#include "sim/study/bench.h"

#include <algorithm>
#include <limits>

#include "sim/motion/stop.h"

namespace taut::study {
namespace {

/// The cost (s) of two looks at the clock with nothing between them.
double clock_cost() {
  double least = 1;
  for (int i = 0; i < 1000; ++i) {
    const double before = thread_seconds();
    least = std::min(least, thread_seconds() - before);
  }
  return least;
}

}  // namespace

std::vector<BenchRow> bench(const Problem& problem, std::span<const MethodChoice> candidates,
                            const BenchOptions& options) {
  struct Timings {
    std::vector<std::vector<double>> frames;  // [frame][repeat], s
    std::vector<double> means;
    double spent = 0;
  };
  const double overhead = clock_cost();
  std::vector<BenchRow> rows;
  for (const MethodChoice& candidate : candidates) rows.push_back({candidate, {}, {}, {}, 0, 0});
  std::vector<Timings> timings(rows.size());
  for (std::size_t repeat = 0; repeat < options.repeats; ++repeat) {
    for (std::size_t c = 0; c < rows.size(); ++c) {
      Timings& timing = timings[c];
      if (!rows[c].failure.empty() || timing.spent > options.seconds) continue;
      if (options.pause) options.pause();
      Simulation simulation(problem.world,
                            make_method(rows[c].candidate.name, rows[c].candidate.settings),
                            problem.timeline);
      timing.frames.resize(problem.times.size());
      double sum = 0;
      // Each part of the budget is there for many runs: what one alone exceeds is not timed.
      const WorkLimit limit({.cpu_time = 2 * options.seconds});
      try {
        for (std::size_t k = 0; k < problem.times.size(); ++k) {
          const double before = thread_seconds();
          simulation.advance_to(problem.times[k]);
          const double cost = std::max(0.0, thread_seconds() - before - overhead);
          timing.frames[k].push_back(cost);
          sum += cost;
        }
        const auto frames = static_cast<double>(problem.times.size());
        timing.means.push_back(sum / frames);
        rows[c].steps = static_cast<double>(simulation.method().counters().steps) / frames;
      } catch (const OverLimit&) {
        if (!limit.reached()) throw;
        if (timing.means.empty()) rows[c].failure = "not run: over its share of the budget";
        timing.spent = std::numeric_limits<double>::infinity();
        timing.frames.clear();
      } catch (const Diverged& error) {
        rows[c].failure = error.what();
      } catch (const BadIntervention& error) {
        rows[c].failure = error.what();
      }
      timing.spent += sum;
    }
  }
  for (std::size_t c = 0; c < rows.size(); ++c) {
    for (const std::vector<double>& frame : timings[c].frames) {
      rows[c].frames.push_back(spread(frame));
    }
    rows[c].mean = spread(timings[c].means);
    rows[c].repeats = timings[c].means.size();
  }
  return rows;
}

}  // namespace taut::study
