// The integrator for loose errors where waves do not stiffen the motion: one solve a step.
#pragma once

#include "sim/methods/direct/arena.h"
#include "sim/methods/direct/motion.h"

namespace taut::direct {

/// The leapfrog of Stoermer and Verlet, of order 2, in the places of the particles: it knows no
/// speeds but those between its states, so that links which turn fast or fold, pushed or pulled,
/// cannot run away with it. Where the last tensions lead, lengths are off by little, which takes
/// one linear system to mend (Motion::leap).
class LeapStep {
 public:
  /// Takes its arrays from `arena`.
  void make_arrays(Arena& arena);

  struct Outcome {
    double error = 0;       // m, estimated
    double correction = 0;  // of a link's length, the most that a new link was off
  };
  /// Tries a step of h (s) from q at `time`, where one of `last` (s) from q_before led. The result
  /// is left for accept().
  Outcome attempt(Motion& motion, double time, double h, double last, const double* q,
                  const double* q_before);

  /// Swaps the result of the last attempt with the caller's state, and puts the rate of what was
  /// the state, between two steps now, where that state has gone to.
  void accept(Slice& q, Slice& rate, Slice& rate_before);

  /// The order by which the error falls with h.
  static constexpr double kErrorOrder = 3;

  static constexpr std::size_t kArrays = 4;

 private:
  Slice q_, rate_, rate_between_, error_;
};

}  // namespace taut::direct
