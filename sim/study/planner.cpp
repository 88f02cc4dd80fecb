#include "sim/study/planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>

#include "sim/motion/side_by_side.h"
#include "sim/motion/stop.h"

namespace taut::study {

double distance_between(const ReferenceSolution& reference, const World& world,
                        const Timeline& timeline, const MethodChoice& candidate,
                        const Distance& distance, double cpu_cap) {
  const WorkLimit limit({.cpu_time = cpu_cap});
  ComparedRun compared(reference, world, timeline, candidate, distance);
  try {
    for (std::size_t k = 0; k < reference.known; ++k) compared.next();
  } catch (const Diverged&) {
    return INFINITY;
  }
  return compared.error();
}

std::optional<double> error_of_chain(double twice, double four) {
  constexpr double kSlowest = 0.9;  // the factor above which nothing can be told
  if (twice == 0 && four == 0) return 0;
  const double factor = std::abs(four / twice - 1);
  if (!(factor < kSlowest)) return std::nullopt;
  return twice / (1 - factor);
}

namespace {

/// True where every frame takes the same work: no error is controlled.
bool has_equal_steps(const MethodChoice& candidate) {
  return std::ranges::none_of(std::array{"tolerance", "accuracy", "local_error"},
                              [&](const char* name) { return candidate.settings.contains(name); });
}

/// Which of a model's candidates are sure to be dearer than another.
class Dearness {
 public:
  explicit Dearness(const std::vector<MethodChoice>& candidates) {
    for (const MethodChoice& one : candidates) {
      for (const auto& [name, value] : one.settings) {
        const double* number = std::get_if<double>(&value);
        if (!number) continue;
        const auto [first, is_new] = ranges_.try_emplace(one.name + ' ' + name, *number, *number);
        first->second.second = *number;
      }
    }
  }

  /// All numbers of `a` are those of `b`, or later ones of the sweep; all else is the same.
  bool at_least(const MethodChoice& a, const MethodChoice& b) const {
    if (a.name != b.name || a.settings.size() != b.settings.size()) return false;
    return std::ranges::all_of(a.settings, [&](const auto& setting) {
      const auto& [name, value] = setting;
      const auto other = b.settings.find(name);
      if (other == b.settings.end()) return false;
      if (value == other->second) return true;
      const double *mine = std::get_if<double>(&value), *its = std::get_if<double>(&other->second);
      if (!mine || !its) return false;
      const auto& [cheap, dear] = ranges_.at(a.name + ' ' + name);
      return (*mine > *its) == (dear > cheap);
    });
  }

 private:
  std::map<std::string, std::pair<double, double>> ranges_;  // the first and the last of each
};

/// Goes on as long as `end_of` says that the trial is within. After the first frame that takes work
/// it says what equal steps will take to the end, so that what is too dear is not run.
Trial run(const PlanModel& model, const MethodChoice& candidate, const ReferenceSolution& reference,
          const Distance& distance, double cpu_cap,
          const std::function<Trial::End(const Trial&)>& end_of) {
  const std::vector<double>& times = reference.problem.times;
  const double span = times.back() - times.front();
  Trial trial;
  const WorkLimit limit({.cpu_time = cpu_cap});
  try {
    ComparedRun compared(reference, model.world, model.timeline, candidate, distance);
    const bool equal = has_equal_steps(candidate);
    for (std::size_t k = 0; trial.end == Trial::End::within && compared.next(); ++k) {
      trial.error = compared.error();
      trial.later = compared.later();
      trial.cycles = compared.cycles() / span;
      if (k == 1 && equal) trial.cycles *= span / (times[1] - times[0]);
      trial.end = end_of(trial);
    }
  } catch (const OverLimit&) {
    if (!limit.reached()) throw;
    trial.end = Trial::End::cut;
  } catch (const Diverged&) {
    trial.end = Trial::End::diverged;
  } catch (const BadIntervention&) {
    trial.end = Trial::End::diverged;
  } catch (const std::invalid_argument&) {
    trial.end = Trial::End::diverged;
  }
  return trial;
}

}  // namespace

Trial attempt(const PlanModel& model, const MethodChoice& candidate,
              const ReferenceSolution& reference, const Tolerance& tolerance, double most_cycles,
              double cpu_cap) {
  return run(model, candidate, reference, tolerance.distance, cpu_cap, [&](const Trial& trial) {
    if (!(trial.error <= tolerance.most)) return Trial::End::beyond;
    if (!trial.later.within(reference.most)) return Trial::End::unlike;
    return trial.cycles > most_cycles ? Trial::End::dearer : Trial::End::within;
  });
}

Trial run_through(const PlanModel& model, const MethodChoice& candidate,
                  const ReferenceSolution& reference, const Distance& distance, double cpu_cap) {
  return run(model, candidate, reference, distance, cpu_cap,
             [](const Trial&) { return Trial::End::within; });
}

Search search(std::span<const PlanModel> models, const ReferenceSolution& reference,
              const Tolerance& tolerance, const std::function<void(std::size_t)>& tried,
              const TimeLeft& left) {
  // A few at a time on all cores; earlier results tell which are too dear, so that the outcome is
  // the same on any number of cores.
  constexpr std::size_t kBlock = 4;
  Search result;
  double least = std::numeric_limits<double>::infinity();
  std::mutex alone;
  std::size_t done = 0;

  const auto run_block = [&](std::vector<Trial>& block) {
    const double cap = left && !block.empty() ? left() / static_cast<double>(block.size())
                                              : std::numeric_limits<double>::infinity();
    if (!(cap > 0)) {
      result.left_out += block.size();
      block.clear();
    }
    side_by_side(block.size(), [&](std::size_t i) {
      const auto [m, c] = std::pair(block[i].model, block[i].candidate);
      const MethodChoice& candidate = models[m].candidates[c];
      std::unique_lock lock(alone, std::defer_lock);
      if (find_method(candidate.name)->runs_alone) lock.lock();
      const Tolerance own = tolerance;  // a distance may remember what it was asked last
      block[i] = attempt(models[m], candidate, reference, own, least, cap);
      block[i].model = m;
      block[i].candidate = c;
    });
    for (const Trial& trial : block) {
      // Of equals, the first model.
      const bool first =
          trial.cycles == least && result.best && trial.model < result.trials[*result.best].model;
      if (trial.end == Trial::End::within && (trial.cycles < least || first)) {
        least = trial.cycles;
        result.best = result.trials.size();
      }
      if (trial.end == Trial::End::cut) ++result.left_out;
      result.trials.push_back(trial);
    }
    tried(done);
  };

  const auto try_model = [&](std::size_t m, const std::vector<std::size_t>& numbers) {
    const std::vector<MethodChoice>& candidates = models[m].candidates;
    const Dearness dearness(candidates);
    std::vector<std::size_t> enough;  // candidates, which need not be dearer
    for (std::size_t next = 0; next < numbers.size();) {
      std::vector<Trial> block;
      for (; next < numbers.size() && block.size() < kBlock; ++next, ++done) {
        if (std::ranges::none_of(enough, [&](std::size_t other) {
              return dearness.at_least(candidates[numbers[next]], candidates[other]);
            })) {
          block.push_back({.model = m, .candidate = numbers[next]});
        }
      }
      run_block(block);
      for (const Trial& trial : block) {
        if (trial.end == Trial::End::dearer || trial.end == Trial::End::within ||
            trial.end == Trial::End::cut) {
          enough.push_back(trial.candidate);
        }
      }
    }
  };

  for (const bool likely : {true, false}) {
    for (std::size_t m = models.size(); m-- > 0;) {
      const std::vector<MethodChoice>& candidates = models[m].candidates;
      std::vector<std::size_t> numbers;
      for (std::size_t c = 0; c < candidates.size(); ++c) {
        if ((candidates[c].name == candidates.front().name) == likely) numbers.push_back(c);
      }
      try_model(m, numbers);
    }
  }
  return result;
}

}  // namespace taut::study
