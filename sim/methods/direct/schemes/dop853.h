// Explicit Runge-Kutta of order 8 for second-order motion.
#pragma once

#include "sim/methods/direct/schemes/arena.h"
#include "sim/methods/direct/schemes/dop853_table.h"
#include "sim/methods/direct/system/motion.h"

namespace taut::direct {

/// One step of DOP853. Written for q'' = a(t, q, q'), where the stages of q follow from those of q'
/// (Nystrom's form), so that only accelerations are kept.
class Dop853Step {
 public:
  /// Takes the arrays of its results, and those that it needs within an attempt, from `arena`.
  void make_results(Arena& arena);
  void make_workspace(Arena& arena);

  /// Tries a step of h (s) from (q, rate) at `time`, whose acceleration is `first`; returns the
  /// estimated error (m).
  double attempt(Motion& motion, double time, double h, const double* q, const double* rate,
                 const double* first);

  // After the last attempt.
  const double* q() const { return q_.data(); }
  const double* rate() const { return rate_.data(); }
  /// Swaps the result of the last attempt with the caller's state.
  void swap_result(Slice& q, Slice& rate) {
    q_.swap(q);
    rate_.swap(rate);
  }

  /// The order by which the error estimate falls with h, for step control.
  static constexpr double kErrorOrder = 8;
  /// Steps are stable for frequencies (rad/s) up to 5.9 / h; less, as tensions rise in a step.
  static constexpr double kStable = 5.2;
  /// The cost of a step beside projections, in accelerations: eleven stages and their sums,
  /// measured.
  static constexpr double kCost = 12.5;

  static constexpr std::size_t kResults = 2, kWorkspace = kStages + 1;

 private:
  std::array<Slice, kStages> accelerations_;  // by stage; that of stage 0 is the caller's
  Slice q_, rate_, error_q_, error_rate_;
};

}  // namespace taut::direct
