// The implicit scheme: one acceleration a step, however fast the waves are.
#pragma once

#include "sim/methods/direct/arena.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/system.h"

namespace taut::direct {

/// The two-step backward differentiation formula (BDF2) for any ratio of steps: order 2, L-stable
/// (Hairer and Wanner, Solving Ordinary Differential Equations II, V). Of its equations it takes
/// one iteration of Newton's, from where the last accelerations lead, with the waves under the
/// tensions there for the Jacobian; then lengths are kept.
class BdfStep {
 public:
  /// Takes its arrays from `arena`.
  void make_arrays(Arena& arena);

  /// Begins at (q, v) with acceleration a as if a step of h (s) had led there; leaves in the last
  /// two arrays where that would have begun.
  void begin(double h, const double* q, const double* v, const double* a, double* q_before,
             double* v_before);

  /// Tries a step of h (s) from (q, v) at `time`, where one of `last` (s) from (q_before, v_before)
  /// led. The result is left for accept(). An error of speed counts for `memory` (s).
  Outcome attempt(System& system, double time, double h, double last, double memory,
                  const double* q, const double* v, const double* q_before, const double* v_before);

  /// Swaps the result of the last attempt with the caller's state.
  void accept(Slice& q, Slice& v);

  /// The order by which the error of a step falls with h.
  static constexpr double kErrorOrder = 3;
  static constexpr std::size_t kArrays = 7;

 private:
  Slice older_, old_, new_;  // the last accelerations, as the formula has them
  bool first_ = true;        // of the steps since begin()
  Slice x_, known_;
  Slice q_, v_;
};

}  // namespace taut::direct
