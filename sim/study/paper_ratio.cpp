#include "sim/study/paper_ratio.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "sim/motion/stop.h"
#include "sim/study/speed_accuracy.h"

namespace taut::study {
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
