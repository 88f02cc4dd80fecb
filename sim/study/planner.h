// The planner: of many models and settings, the cheapest that stays within a tolerance of the
// reference solution.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "sim/evaluation/reference_solution.h"

namespace taut::study {

// How far a chain of particles is from the continuous rope that it stands for.

/// The largest distance of any of the reference solution's points in the frames that can be
/// compared, for a world that models the same in another way; infinite where it cannot be run that
/// far. Throws OverLimit where that takes more than `cpu_cap` (s).
double distance_between(const ReferenceSolution& reference, const World& world,
                        const Timeline& timeline, const MethodChoice& candidate,
                        const Distance& distance,
                        double cpu_cap = std::numeric_limits<double>::infinity());

/// Where chains of n, 2n, 4n links tend to, from how far the second (`twice`) and the third
/// (`four`) are from the first: with errors that shrink by the same factor r each time, these are
/// (1 - r) and (1 - r^2) times the first one's. None where they do not shrink.
std::optional<double> error_of_chain(double twice, double four);

/// A model of the problem, and the candidates that may solve it.
struct PlanModel {
  World world;
  Timeline timeline;
  std::vector<MethodChoice> candidates;
};

/// A candidate's run, ended as soon as it was of no use.
struct Trial {
  enum class End {
    within,    // of the tolerance, at every frame
    dearer,    // than the best so far
    unlike,    // the reference solution where that is not predictable
    beyond,    // the tolerance, where it can
    diverged,  // or refused by the method
    cut,       // by the CPU time that it may take
  };
  std::size_t model = 0, candidate = 0;
  End end = End::within;
  double error = 0;  // the largest of the frames that it reached, in the tolerance's unit
  Difference later = {};
  double cycles = 0;  // see Counters::cycles, per simulated second
};

struct Search {
  std::vector<Trial> trials;        // one for each candidate that was run, in no certain order
  std::optional<std::size_t> best;  // the cheapest within the tolerance
  std::size_t left_out = 0;         // candidates that were not run, or cut, for want of time
};

struct Tolerance {
  Distance distance;  // of a point from where it should be
  double most = 0;
};

/// The CPU time (s) that all work together may still take; asked again and again.
using TimeLeft = std::function<double()>;

/// A run to the end, or until it is beyond the tolerance, takes more than `most_cycles` (per
/// simulated second) or `cpu_cap` (s) of CPU time.
Trial attempt(const PlanModel& model, const MethodChoice& candidate,
              const ReferenceSolution& reference, const Tolerance& tolerance, double most_cycles,
              double cpu_cap = std::numeric_limits<double>::infinity());

/// A run to the end, whatever its error: within, diverged or cut.
Trial run_through(const PlanModel& model, const MethodChoice& candidate,
                  const ReferenceSolution& reference, const Distance& distance,
                  double cpu_cap = std::numeric_limits<double>::infinity());

/// Tries the candidates of every model, the last model first, those of the method that stands first
/// before all others, until they are beyond the tolerance or dearer than the cheapest within; on
/// all cores. The numbers of a method's settings must go from cheap to dear: past what is within or
/// too dear, dearer ones are not run. `tried` is called with the number of candidates so far, now
/// and then; it may throw to stop. Once no time is left candidates are left out, and those that run
/// are cut.
Search search(std::span<const PlanModel> models, const ReferenceSolution& reference,
              const Tolerance& tolerance, const std::function<void(std::size_t)>& tried,
              const TimeLeft& left = {});

}  // namespace taut::study
