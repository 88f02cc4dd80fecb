// The integrator for loose errors: one acceleration a step, however fast the waves are.
#pragma once

#include "sim/methods/direct/arena.h"
#include "sim/methods/direct/motion.h"

namespace taut::direct {

/// The two-step backward differentiation formula (BDF2) with any ratio of steps: order 2, L-stable.
/// Of its equations it takes one iteration of Newton's, from where the last accelerations lead and
/// with the waves under the tensions there for the Jacobian.
class BackwardStep {
 public:
  /// Takes its arrays from `arena`.
  void make_arrays(Arena& arena);

  /// Begins at (q, rate) with `acceleration` as if a step of h (s) had led there; leaves in the
  /// last two arrays where that would have begun.
  void begin(double h, const double* q, const double* rate, const double* acceleration,
             double* q_before, double* rate_before);

  struct Outcome {
    double error = 0;       // m, estimated
    double correction = 0;  // rad, the most that Newton's iteration turned a direction
  };
  /// Tries a step of h (s) from (q, rate) at `time`, where one of `last` (s) from (q_before,
  /// rate_before) led. The result is left for accept(); infinite where a direction turns by a right
  /// angle.
  Outcome attempt(Motion& motion, double time, double h, double last, const double* q,
                  const double* rate, const double* q_before, const double* rate_before);

  /// Swaps the result of the last attempt with the caller's state.
  void accept(Slice& q, Slice& rate);

  /// The order by which the error falls with h.
  static constexpr double kErrorOrder = 3;

  static constexpr std::size_t kArrays = 8;

 private:
  Slice older_, old_, new_;  // the last accelerations, as the formula has them
  Slice x_, y_, known_;
  Slice q_, rate_;
};

}  // namespace taut::direct
