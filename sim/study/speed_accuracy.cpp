#include "sim/study/speed_accuracy.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "sim/motion/stop.h"

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

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kBorne = 0.9;  // of the stability limit, by the springs' steps
constexpr int kRepeats = 5;
constexpr double kCap = 60;  // CPU s, of one run

const Entrant* entrant_of(std::span<const Entrant> entrants, PaperRole role) {
  const MethodInfo* method = find_method(role);
  if (!method) return nullptr;
  const auto found = std::ranges::find(entrants, method->name, &Entrant::label);
  return found == entrants.end() ? nullptr : &*found;
}

/// The measurements of one problem.
class Measurement {
 public:
  Measurement(const Problem& problem, const truth::Reference& reference, double frame,
              const std::function<void()>& tick)
      : problem_(problem),
        reference_(reference),
        metric_(share_of_length(problem.world.connectors.front().length)),
        frame_(frame),
        tick_(tick) {}

  /// How much the springs cost and err where one frame takes kPaperRatio times as long as of the
  /// proposed method, which takes `steps` in it.
  PaperSetting setting_at(const MethodInfo& springs, const MethodChoice& proposed,
                          double steps) const {
    PaperSetting found;
    found.particles = problem_.world.connectors.front().particles();
    found.impulse_steps = steps;
    found.impulse_cost = cost_of(proposed) * frame_;
    found.impulse_error = scored(proposed, kCap).errors[0];
    const double asked = kPaperRatio * found.impulse_cost;
    const auto cost = [&](double substeps) { return cost_of(hardest(springs, substeps)) * frame_; };
    // The cost of a frame is linear in its steps: find where it is, then once more from nearby.
    found.substeps = 16;
    for (int i = 0; i < 3; ++i) {
      found.substeps =
          std::clamp(std::round(found.substeps * asked / cost(found.substeps)), 1.0, 1e5);
    }
    const MethodChoice equal = hardest(springs, found.substeps);
    found.stiffness = number(equal.settings, "stiffness");
    found.ratio = cost(found.substeps) / found.impulse_cost;
    const AccuracyRow row = scored(equal, kCap);
    found.error = row.errors[0];
    found.stretch = row.stretch_max;
    return found;
  }

  /// Each entrant's runs, cheap ones first, until its share of `seconds` is spent.
  std::vector<std::vector<AccuracyRow>> runs_of(std::span<const Entrant> entrants,
                                                double seconds) const {
    std::vector<std::vector<AccuracyRow>> all;
    const double share = seconds / static_cast<double>(entrants.size());
    for (const Entrant& one : entrants) {
      const Clock::time_point start = Clock::now();
      std::vector<AccuracyRow> rows;
      for (const MethodChoice& candidate : one.candidates) {
        tick_();
        const double spent = std::chrono::duration<double>(Clock::now() - start).count();
        if (spent > share) break;
        rows.push_back(scored(candidate, (share - spent) / 2));
        if (spent < share / 2) add_timing(problem_, rows.back());
      }
      all.push_back(std::move(rows));
    }
    return all;
  }

 private:
  /// CPU s per simulated second, the median of a few runs in a row.
  double cost_of(const MethodChoice& candidate) const {
    std::vector<double> costs;
    for (int i = 0; i < kRepeats; ++i) {
      tick_();
      costs.push_back(time_run(problem_, candidate) / problem_.duration());
    }
    return spread(std::move(costs)).median;
  }

  /// Springs at `substeps` equal steps a frame, as hard as these bear by the theory of a chain at
  /// rest: the longest stable step falls with the root of the stiffness.
  MethodChoice hardest(const MethodInfo& springs, double substeps) const {
    const Settings soft = with_defaults(springs, {{"stiffness", 1.0}});
    const double step = frame_ / substeps;
    const double stiffness =
        std::pow(kBorne * springs.longest_step(problem_.world, soft) / step, 2);
    return {std::string(springs.name), {{"step", step}, {"stiffness", stiffness}}};
  }

  AccuracyRow scored(const MethodChoice& candidate, double cap) const {
    return score(problem_, reference_, std::span(&metric_, 1), candidate, cap);
  }

  const Problem& problem_;
  const truth::Reference& reference_;
  Metric metric_;
  double frame_;  // s
  const std::function<void()>& tick_;
};

}  // namespace

PaperRatio paper_ratio(const Problem& problem, const truth::Reference& reference, double frame,
                       std::span<const Entrant> entrants, double seconds,
                       const std::function<void()>& tick) {
  const Entrant* proposed = entrant_of(entrants, PaperRole::proposed);
  const Entrant* springs = entrant_of(entrants, PaperRole::particle_system);
  PaperRatio result;
  if (!proposed || !springs || problem.times.size() < 2) return result;
  result.horizon = reference.horizon;

  const Measurement measurement(problem, reference, frame, tick);
  const MethodChoice plain{proposed->label, {}}, coarse{proposed->label, {{"step", frame}}};
  const double fallback = number(with_defaults(*proposed->method, {}), "step");
  for (const auto& [choice, steps] :
       {std::pair(coarse, 1.0),
        std::pair(plain, static_cast<double>(step_count(frame, fallback)))}) {
    const WorkLimit limit({.cpu_time = std::max(kCap, seconds)});
    try {
      result.settings.push_back(measurement.setting_at(*springs->method, choice, steps));
    } catch (const OverLimit&) {  // no row
      if (!limit.reached()) throw;
    }
  }

  const auto runs = measurement.runs_of(entrants, seconds);
  const auto points = cost_and_error(runs[static_cast<std::size_t>(proposed - entrants.data())], 0);
  const std::vector<std::size_t> front = pareto_front(points);
  if (front.empty()) return result;
  for (const std::size_t at : {front.front(), front.back()}) {
    for (std::size_t c = 0; c < entrants.size(); ++c) {
      if (&entrants[c] == proposed) continue;
      const auto cost = cost_at(cost_and_error(runs[c], 0), points[at].error);
      result.equal.push_back({problem.world.connectors.front().particles(), points[at].error,
                              entrants[c].label, points[at].cost, cost.value_or(0)});
    }
    if (front.size() == 1) break;
  }
  return result;
}

}  // namespace taut::study
