#include "sim/study/planner.h"

#include <algorithm>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <string>

#include "sim/study/side_by_side.h"

namespace taut {

namespace {

/// True where every frame takes the same work.
bool has_equal_steps(const Candidate& candidate) {
  const auto step = candidate.settings.find("step");
  return step != candidate.settings.end() && std::get<double>(step->second) > 0;
}

/// Goes on as long as `judge` says that the trial is within. After the first frame that takes work
/// it says what equal steps will take to the end, so that what is too dear is not run.
Trial run(const PlanModel& model, const Candidate& candidate, const Exact& exact,
          const Distance& distance, const std::function<Trial::End(const Trial&)>& judge) {
  const std::vector<double>& times = exact.problem.times;
  const double span = times.back() - times.front();
  Trial trial;
  try {
    Beside beside(exact, model.world, model.timeline, candidate, distance);
    const bool equal = has_equal_steps(candidate);
    for (std::size_t k = 0; trial.end == Trial::End::within && beside.next(); ++k) {
      trial.error = beside.error();
      trial.later = beside.later();
      trial.work = beside.work() / span;
      if (k == 1 && equal) trial.work *= span / (times[1] - times[0]);
      trial.end = judge(trial);
    }
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

Trial attempt(const PlanModel& model, const Candidate& candidate, const Exact& exact,
              const Tolerance& tolerance, double most_work) {
  return run(model, candidate, exact, tolerance.distance, [&](const Trial& trial) {
    if (!(trial.error <= tolerance.most)) return Trial::End::beyond;
    if (!trial.later.within(exact.most)) return Trial::End::unlike;
    return trial.work > most_work ? Trial::End::dearer : Trial::End::within;
  });
}

Trial run_through(const PlanModel& model, const Candidate& candidate, const Exact& exact,
                  const Distance& distance) {
  return run(model, candidate, exact, distance, [](const Trial&) { return Trial::End::within; });
}

Search search(std::span<const PlanModel> models, const Exact& exact, const Tolerance& tolerance,
              const std::function<void(std::size_t)>& tried) {
  struct Entry {
    std::size_t model, candidate;
    const Candidate* what;
  };
  std::vector<Entry> entries;
  for (std::size_t m = 0; m < models.size(); ++m) {
    for (std::size_t c = 0; c < models[m].candidates.size(); ++c) {
      entries.push_back({m, c, &models[m].candidates[c]});
    }
  }
  const std::string first = entries.empty() ? "" : entries.front().what->method;
  std::ranges::stable_partition(entries,
                                [&](const Entry& entry) { return entry.what->method == first; });

  // A few at a time on all cores; what is too dear is told by what was found before them, so that
  // the outcome is the same on any number of cores.
  constexpr std::size_t kBlock = 8;
  Search result;
  double least = std::numeric_limits<double>::infinity();
  std::mutex alone;
  for (std::size_t first_of = 0; first_of < entries.size(); first_of += kBlock) {
    const std::size_t count = std::min(kBlock, entries.size() - first_of);
    std::vector<Trial> block(count);
    side_by_side(count, [&](std::size_t i) {
      const Entry& entry = entries[first_of + i];
      // Libraries that others wrote may share what they change.
      std::unique_lock lock(alone, std::defer_lock);
      if (entry.what->method == "multibody" || entry.what->method == "sdfast") lock.lock();
      const Tolerance own = tolerance;  // a distance may remember what it was asked last
      block[i] = attempt(models[entry.model], *entry.what, exact, own, least);
      block[i].model = entry.model;
      block[i].candidate = entry.candidate;
    });
    for (const Trial& trial : block) {
      if (trial.end == Trial::End::within && trial.work < least) {
        least = trial.work;
        result.best = result.trials.size();
      }
      result.trials.push_back(trial);
      tried(result.trials.size());
    }
  }
  return result;
}

}  // namespace taut
