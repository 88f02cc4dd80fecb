// The cheap integrator: linearly implicit in the waves that the tensions carry.
#pragma once

#include <array>

#include "sim/methods/direct/schemes/arena.h"
#include "sim/methods/direct/system/system.h"

namespace taut::direct {

/// One step of ROS34PW2 (Rang and Angermann, BIT 45, 2005): four stages, order 3, L-stable and
/// stiffly accurate. Being a W-method it keeps its order with any approximation of the Jacobian:
/// here the waves under the tensions at the start of the step, whose system is tridiagonal.
///
/// A wave of frequency w that the step passes over is damped, whatever its error, of which the
/// share 1/(1 + (gamma h w)^2) counts as followed: the filter (1 - (gamma h)^2 L)^-1, by the matrix
/// that the stages have factored. Hairer and Wanner, II, IV.8, filter so for the same reason.
class RosenbrockStep {
 public:
  /// Takes the arrays of its results, and those that it needs within an attempt, from `arena`.
  void make_results(Arena& arena);
  void make_workspace(Arena& arena);

  /// Tries a step as Dop853Step::attempt(); the last acceleration that `system` computed must be
  /// `first`. Infinite where a direction turns by a right angle.
  StepError attempt(System& system, double time, double h, const double* q, const double* rate,
                    const double* first);

  // After the last attempt.
  const double* q() const { return q_.data(); }
  const double* rate() const { return rate_.data(); }
  /// Swaps the result of the last attempt with the caller's state.
  void swap_result(Slice& q, Slice& rate) {
    q_.swap(q);
    rate_.swap(rate);
  }

  static constexpr int kStages = 4;
  static constexpr std::size_t kResults = 2, kWorkspace = 2 * kStages + 4;
  static constexpr double kErrorOrder = 3;
  /// The cost of a step beside projections, in accelerations; measured.
  static constexpr double kCost = 7;

 private:
  std::array<Slice, kStages> dx_, dy_;  // by stage: increments of x and of its rate
  Slice q_, rate_, chart_rate_, acceleration_, error_q_, error_rate_;
};

}  // namespace taut::direct
