// The scheme for coarse work and fast waves: one solve a step.
#pragma once

#include "sim/methods/direct/arena.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/system.h"

namespace taut::direct {

/// Position Verlet (Stoermer's method) with SHAKE (Ryckaert, Ciccotti and Berendsen, 1977), of
/// order 2, for steps of any length; the constraints' equations are solved by one iteration of
/// Newton's that begins at the last tensions. It knows no velocities but those between its states,
/// so that links which turn fast or fold cannot run away with it.
class VerletStep {
 public:
  /// Takes its arrays from `arena`.
  void make_arrays(Arena& arena);

  /// An acceleration at some time (s).
  struct Known {
    double at = 0;
    const double* a = nullptr;
  };
  /// Begins at (q, v) with acceleration a as if a step of h (s) had led there, of which the last
  /// tensions are; writes where that would have begun. Two earlier accelerations, the later one
  /// first, are for the error estimate.
  void begin(double h, const double* q, const double* v, const double* a, const Known& old,
             const Known& older, double* q_before);

  /// Tries a step of h (s) from q at `time`, where one of `last` (s) from q_before led. The result
  /// is left for accept().
  Outcome attempt(System& system, double time, double h, double last, double memory, double* q,
                  const double* q_before);

  /// Swaps the result of the last attempt with the caller's state, and writes the velocities that
  /// it had at the start of the step.
  void accept(Slice& q, Slice& v, Slice& v_before);

  /// The order by which the error estimate of a step falls with h.
  static constexpr double kErrorOrder = 3;
  /// Steps are stable for frequencies (rad/s) up to 2 / h.
  static constexpr double kStable = 2;
  static constexpr std::size_t kArrays = 7;

 private:
  Slice q_, v_, v_between_, error_, new_, old_, older_;
  double at_ = 0, old_at_ = 0, older_at_ = 0;  // s, of those accelerations
};

}  // namespace taut::direct
