#include "sim/methods/direct/verlet.h"

#include <algorithm>

#include "sim/methods/direct/vector.h"

namespace taut::direct {
namespace {

using Out = double* __restrict;
using In = const double* __restrict;

TAUT_VECTOR_CLONES
void look_back(std::size_t n, double h, In q, In v, In a, Out before) {
  for (std::size_t i = 0; i < n; ++i) before[i] = q[i] - h * (v[i] - h / 2 * a[i]);
}

constexpr double kSaturation = 4;

/// Where points go without forces.
TAUT_VECTOR_CLONES
void coast(std::size_t n, double ratio, In before, In q, Out next) {
  for (std::size_t i = 0; i < n; ++i) next[i] = q[i] + ratio * (q[i] - before[i]);
}

/// The acceleration that led to `next`; and the scheme's leading error of it, h^2 / 12 of its
/// second derivative, which the last three have over the times `second` and `first` between them.
TAUT_VECTOR_CLONES
void bend(std::size_t n, double h, double last, double second, double first, In before, In q,
          In next, In old, In older, Out a, Out error) {
  const double ratio = h / last, per = 2 / (h * (h + last));
  const double scale = h * h / (6 * (second + first));
  for (std::size_t i = 0; i < n; ++i) {
    a[i] = (next[i] - q[i] - ratio * (q[i] - before[i])) * per;
    error[i] = scale * ((a[i] - old[i]) / second - (old[i] - older[i]) / first);
  }
}

/// The derivatives of the parabola through three states, in the middle and at the end.
TAUT_VECTOR_CLONES
void velocities(std::size_t n, double h, double last, In before, In q, In next, Out between,
                Out end) {
  const double per_h = 1 / h, per_last = 1 / last, share = h / (h + last);
  for (std::size_t i = 0; i < n; ++i) {
    const double now = (next[i] - q[i]) * per_h, then = (q[i] - before[i]) * per_last;
    const double turn = share * (now - then);
    between[i] = now - turn;
    end[i] = now + turn;
  }
}

}  // namespace

void VerletStep::make_arrays(Arena& arena) {
  for (Slice* slice : {&q_, &v_, &v_between_, &error_, &new_, &old_, &older_}) {
    *slice = arena.make();
  }
}

void VerletStep::begin(double h, const double* q, const double* v, const double* a,
                       const Known& old, const Known& older, double* q_before) {
  look_back(q_.size(), h, q, v, a, q_before);
  std::copy_n(old.a, old_.size(), old_.begin());
  std::copy_n(older.a, older_.size(), older_.begin());
  old_at_ = old.at;
  older_at_ = older.at;
}

Outcome VerletStep::attempt(System& system, double time, double h, double last, double memory,
                            double* q, const double* q_before) {
  const std::size_t size = q_.size();
  const double ratio = h / last, factor = h * (h + last) / 2;
  coast(size, ratio, q_before, q, q_.data());
  const double excess = system.shake(time + h, factor, q, q_.data(), v_.data());
  // A second difference over unequal steps is the acceleration at the mean of its three times.
  at_ = time + (h - last) / 3;
  bend(size, h, last, at_ - old_at_, old_at_ - older_at_, q_before, q, q_.data(), old_.data(),
       older_.data(), new_.data(), error_.data());
  velocities(size, h, last, q_before, q, q_.data(), v_between_.data(), v_.data());
  // Its acceleration errs by (h w)^2 / 12.
  const double error = system.accumulated(memory, kSaturation / (h * h), error_.data());
  return {.error = error, .excess = excess, .frequency = system.frequency()};
}

void VerletStep::accept(Slice& q, Slice& v, Slice& v_before) {
  q_.swap(q);
  v_.swap(v);
  v_between_.swap(v_before);
  older_.swap(old_);
  old_.swap(new_);
  older_at_ = old_at_;
  old_at_ = at_;
}

}  // namespace taut::direct
