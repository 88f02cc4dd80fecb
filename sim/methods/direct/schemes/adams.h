// The integrator that looks back: one acceleration per step, the rest from those of earlier steps.
#pragma once

#include <array>
#include <cstddef>

#include "sim/methods/direct/schemes/arena.h"
#include "sim/methods/direct/system/system.h"

namespace taut::direct {

/// Adams's methods on equally spaced steps, of order 4: q follows from the accelerations before the
/// step (Bashforth's), its rate also from the one at its end (Moulton's), which is taken at a rate
/// of Bashforth's kind. Waves hardly depend on that rate, so that steps may be half as long again
/// as with Bashforth's alone, and err by a third.
class AdamsStep {
 public:
  /// Takes its arrays from `arena`; it remembers nothing.
  void make_arrays(Arena& arena);

  /// Forgets everything.
  void clear() { known_ = 0; }
  /// Begins with accelerations that are h (s) apart; returns where to write them, the latest first.
  std::array<double*, 4> begin(double h);
  /// The longest step (s) that it remembers enough for; zero: it has not begun.
  double longest() const;
  /// Makes h the spacing; false where that is too long.
  bool prepare(double h);
  double spacing() const { return h_; }  // s
  /// The acceleration that it remembers from `steps` ago.
  const double* past(std::size_t steps) const { return past_[steps].data(); }

  /// Tries a step of spacing() from (q, rate) at `time`. The result is left for swap_result();
  /// returns the estimated error (m), or a bound of it where that is below `unimportant`.
  double attempt(System& system, double time, const double* q, const double* rate,
                 double unimportant);
  /// Remembers the acceleration at the end of the step.
  void accept();

  /// Swaps the result of the last attempt with the caller's state.
  void swap_result(Slice& q, Slice& rate) {
    q_.swap(q);
    rate_.swap(rate);
  }

  /// The order by which the error estimate falls with h.
  static constexpr double kErrorOrder = 5;
  /// Steps are stable for frequencies (rad/s) up to 1.6 / h, by the roots of the recurrence for
  /// q'' = -w^2 q, and damp them below; less, as tensions rise and links turn in a step.
  static constexpr double kStable = 1.4;
  /// The cost of a step beside projections, in accelerations; measured.
  static constexpr double kCost = 1.6;

  /// A spacing is kept down to this share of the step that is possible: a new one costs an
  /// interpolation of what is remembered, and half of the memory where it is wider.
  static constexpr double kLeastSpacing = 0.75;

  static constexpr std::size_t kKept = 6;
  static constexpr std::size_t kArrays = 2 * kKept + 4;

 private:
  void respace(double h);

  std::array<Slice, kKept> past_;  // accelerations, the latest first
  std::array<Slice, kKept> spare_;
  Slice next_;             // that at the end of the step
  std::size_t known_ = 0;  // of past_
  double h_ = 0;           // s, between them
  Slice q_, rate_, error_;
};

}  // namespace taut::direct
