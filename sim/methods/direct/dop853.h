// The careful integrator: explicit Runge-Kutta of order 8 for second-order motion.
#pragma once

#include <vector>

#include "sim/methods/direct/dop853_table.h"
#include "sim/methods/direct/motion.h"

namespace taut::direct {

/// One step of DOP853. Written for q'' = a(t, q, q'), where the stages of q follow from those of q'
/// (Nystrom's form), so that only accelerations are kept.
class Dop853Step {
 public:
  explicit Dop853Step(std::size_t size);

  /// Tries a step of h (s) from (q, rate) at `time`, whose acceleration is `first`. The result is
  /// in q() and rate(); returns the estimated error (m).
  double attempt(Motion& motion, double time, double h, const double* q, const double* rate,
                 const double* first);

  const std::vector<double>& q() const { return q_; }
  const std::vector<double>& rate() const { return rate_; }

  /// The order by which the error estimate falls with h, for step control.
  static constexpr double kErrorOrder = 8;
  /// Steps are stable for frequencies (rad/s) up to 5.9 / h; less, as tensions rise in a step.
  static constexpr double kStable = 5.2;

 private:
  std::size_t size_;
  std::vector<double> accelerations_;  // [stage - 1][size]; stage 0 is the caller's
  std::vector<double> q_, rate_, error_q_, error_rate_;
};

}  // namespace taut::direct
