// The explicit scheme of high order.
#pragma once

#include "sim/methods/direct/arena.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/dop853_table.h"
#include "sim/methods/direct/system.h"

namespace taut::direct {

/// DOP853, an explicit Runge-Kutta method of order 8 (Hairer, Norsett and Wanner, Solving Ordinary
/// Differential Equations I, II.10). Written for q'' = a(t, q, q'), where the stages of q follow
/// from those of q' (Nystrom's form), so that only accelerations are kept.
class Dop853Step {
 public:
  /// Takes its arrays from `arena`.
  void make_arrays(Arena& arena);

  /// Tries a step of h (s) from (q, v) at `time`, whose acceleration is `first`. The result is left
  /// for swap_result(); returns the estimated error (m) of place and speed, an error of speed
  /// counting for `memory` (s).
  Outcome attempt(System& system, double time, double h, double memory, const double* q,
                  const double* v, const double* first, double verlet, double span);

  /// Swaps the result of the last attempt with the caller's state.
  void swap_result(Slice& q, Slice& v) {
    q_.swap(q);
    v_.swap(v);
  }

  /// The acceleration at this share of the last step that was tried.
  static constexpr double kInner = 0.6;
  const double* inner() const { return accelerations_[9].data(); }

  /// The order by which the error estimate falls with h, for step control.
  static constexpr double kErrorOrder = 8;
  /// Steps are stable for frequencies (rad/s) up to 5.9 / h; less, as tensions rise in a step.
  static constexpr double kStable = 5.2;

  static constexpr std::size_t kArrays = kStages + 3;

 private:
  std::array<Slice, kStages> accelerations_;  // by stage; that of stage 0 is the caller's
  Slice q_, v_, error_q_, error_v_;
};

}  // namespace taut::direct
