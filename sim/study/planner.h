// The planner: of many models and settings, the one that takes the least work and that nobody can
// tell from the truth.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/simulation.h"
#include "sim/study/accuracy.h"
#include "sim/study/candidate.h"
#include "sim/study/reference.h"

namespace taut {

/// One way to model what happens, and what may solve it.
struct PlanModel {
  World world;
  Timeline timeline;
  std::vector<Candidate> candidates;
};

/// A candidate's run, ended as soon as it was of no use.
struct Trial {
  enum class End {
    within,    // of the tolerance, at every frame
    beyond,    // the tolerance
    dearer,    // than the best so far
    diverged,  // or refused by the method
  };
  std::size_t model = 0, candidate = 0;
  End end = End::within;
  double error = 0;  // the largest of the frames that it reached, in the tolerance's unit
  double work = 0;   // of MethodInfo::work, per simulated second
};

struct Search {
  std::vector<Trial> trials;        // one for each candidate of each model, in their order
  std::optional<std::size_t> best;  // the cheapest within the tolerance
};

struct Tolerance {
  Distance distance;  // of a point from where it should be
  double most = 0;
};

/// The work of the solves so far, from counts: the same on every machine.
double work_of(const Candidate& candidate, const World& world, const Counters& counters);

/// The largest error of a candidate along `truth`, in the unit of `distance`; infinite where it
/// cannot be run to the end.
double error_along(const World& world, const Timeline& timeline, const Candidate& candidate,
                   const World& exact, const Reference& truth, const Distance& distance);

/// Runs every candidate of every model along `truth` (frames up to the horizon, of the world
/// `exact`) until it is beyond the tolerance or dearer than the cheapest within. `tried` is called
/// after each with the number so far; it may throw to stop.
Search search(std::span<const PlanModel> models, const World& exact, const Reference& truth,
              const Tolerance& tolerance, const std::function<void(std::size_t)>& tried);

}  // namespace taut
