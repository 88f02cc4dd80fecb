#include "sim/study/planner.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/study/marks.h"

namespace taut {
namespace {

/// What is compared: the marks of the exact world in every frame.
struct Course {
  Course(const World& exact, const Reference& truth) : marks(exact, truth.frames.front()) {
    for (const Snapshot& frame : truth.frames) right.push_back(marks.places(marks, frame));
  }
  Marks marks;
  std::vector<std::vector<Vec3>> right;  // [frame][mark]
};

/// The largest distance of any mark.
double error_of(const std::vector<Vec3>& at, const std::vector<Vec3>& truth, double time,
                const Distance& distance) {
  double largest = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double error = distance(at[i], truth[i], time);
    if (!(error <= largest)) largest = error;  // keeps what is no number, too
  }
  return largest;
}

}  // namespace

double work_of(const Candidate& candidate, const World& world, const Counters& counters) {
  const MethodInfo& method = *find_method(candidate.method);
  double links = 0;
  for (const Connector& connector : world.connectors) {
    links += static_cast<double>(connector.links());
  }
  return static_cast<double>(counters.solves) *
         method.work(with_defaults(method, candidate.settings), links);
}

double error_along(const World& world, const Timeline& timeline, const Candidate& candidate,
                   const World& exact, const Reference& truth, const Distance& distance) {
  const Course course(exact, truth);
  double error = 0;
  try {
    Simulation simulation(world, make_method(candidate.method, candidate.settings), timeline);
    const Marks own(world, simulation.state());
    for (std::size_t k = 0; k < truth.frames.size(); ++k) {
      const double time = truth.frames[k].time;
      simulation.advance_to(time);
      error = std::max(error, error_of(own.places(course.marks, simulation.state()),
                                       course.right[k], time, distance));
    }
  } catch (const Diverged&) {
    return std::numeric_limits<double>::infinity();
  }
  return error;
}

Search search(std::span<const PlanModel> models, const World& exact, const Reference& truth,
              const Tolerance& tolerance, const std::function<void(std::size_t)>& tried) {
  const Course course(exact, truth);
  const double span = truth.frames.back().time - truth.frames.front().time;

  Search result;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t m = 0; m < models.size(); ++m) {
    const PlanModel& model = models[m];
    for (std::size_t c = 0; c < model.candidates.size(); ++c) {
      const Candidate& candidate = model.candidates[c];
      Trial trial{m, c};
      try {
        Simulation simulation(model.world, make_method(candidate.method, candidate.settings),
                              model.timeline);
        const Marks own(model.world, simulation.state());
        for (std::size_t k = 0; k < truth.frames.size() && trial.end == Trial::End::within; ++k) {
          simulation.advance_to(truth.frames[k].time);
          trial.error = std::max(
              trial.error, error_of(own.places(course.marks, simulation.state()), course.right[k],
                                    truth.frames[k].time, tolerance.distance));
          trial.work =
              work_of(candidate, simulation.world(), simulation.method().counters()) / span;
          if (!(trial.error <= tolerance.most)) {
            trial.end = Trial::End::beyond;
          } else if (trial.work > least) {
            trial.end = Trial::End::dearer;
          }
        }
      } catch (const Diverged&) {
        trial.end = Trial::End::diverged;
      } catch (const std::invalid_argument&) {
        trial.end = Trial::End::diverged;
      }
      if (trial.end == Trial::End::within) {
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
