// The integrator that looks back: one acceleration per step, the rest from those of earlier steps.
#pragma once

#include <array>
#include <cstddef>

#include "sim/methods/direct/arena.h"
#include "sim/methods/direct/motion.h"

namespace taut::direct {

/// The explicit method of four accelerations on equally spaced steps, of order 4: Stoermer's for q,
/// Adams' and Bashforth's for its rate.
class AdamsStep {
 public:
  /// Takes its arrays from `arena`; it remembers nothing.
  void make_arrays(Arena& arena);

  /// Forgets everything.
  void clear() { known_ = 0; }
  /// Remembers the acceleration at the present state, one step of `h` (s) after the last one; a
  /// different h forgets those before.
  void remember(const double* acceleration, double h);
  /// Whether it remembers some steps, but not enough.
  bool begun() const { return known_ > 1 && longest() == 0; }
  /// The longest step (s) that it remembers enough for; zero: none.
  double longest() const;
  /// Makes h the spacing; false where that is too long.
  bool prepare(double h);
  double spacing() const { return h_; }  // s
  /// The acceleration that it remembers from `steps` ago, one of known().
  const double* past(std::size_t steps) const { return past_[steps].data(); }
  std::size_t known() const { return known_; }

  /// Tries a step of spacing() from (q, rate) at `time`. The result is left for swap_result();
  /// returns the estimated error (m), or a bound of it where that is below `unimportant`.
  double attempt(Motion& motion, double time, const double* q, const double* rate,
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
  /// Steps are stable for frequencies (rad/s) up to 1.0 / h, by the roots of the recurrence for
  /// q'' = -w^2 q, and damp them below; less, as tensions rise in a step.
  static constexpr double kStable = 0.92;

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
