#include "sim/methods/direct/leap.h"

#include "sim/methods/direct/vector.h"

namespace taut::direct {
namespace {

using Out = double* __restrict;
using In = const double* __restrict;

/// The share of what the lengths took to mend that the step errs by: tensions that change linearly,
/// where the last ones were taken, are mended right; measured.
constexpr double kShareOfMended = 0.3;

/// The derivatives of the parabola through three states, in the middle and at the end.
TAUT_VECTOR_CLONES
void rates(std::size_t n, double h, double last, In q_before, In q, In q_next, Out between,
           Out end) {
  const double per_h = 1 / h, per_last = 1 / last, share = h / (h + last);
  for (std::size_t i = 0; i < n; ++i) {
    const double now = (q_next[i] - q[i]) * per_h, before = (q[i] - q_before[i]) * per_last;
    const double bend = share * (now - before);
    between[i] = now - bend;
    end[i] = now + bend;
  }
}

}  // namespace

void LeapStep::make_arrays(Arena& arena) {
  for (Slice* slice : {&q_, &rate_, &rate_between_, &error_}) *slice = arena.make();
}

LeapStep::Outcome LeapStep::attempt(Motion& motion, double time, double h, double last,
                                    const double* q, const double* q_before) {
  const double correction = motion.leap(time, h, last, q, q_before, q_.data(), error_.data());
  rates(q_.size(), h, last, q_before, q, q_.data(), rate_between_.data(), rate_.data());
  return {kShareOfMended * motion.shift(error_.data()), correction};
}

void LeapStep::accept(Slice& q, Slice& rate, Slice& rate_before) {
  q_.swap(q);
  rate_.swap(rate);
  rate_between_.swap(rate_before);
}

}  // namespace taut::direct
