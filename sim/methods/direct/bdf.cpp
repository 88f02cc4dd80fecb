#include "sim/methods/direct/bdf.h"

#include <algorithm>
#include <cmath>

#include "sim/methods/direct/vector.h"

namespace taut::direct {
namespace {

using Out = double* __restrict;
using In = const double* __restrict;

/// For a step of h after one of `last`: y = now y_n - before y_{n-1} + beta f(y); Hairer, Norsett
/// and Wanner, Solving Ordinary Differential Equations I, III.5.
struct Formula {
  Formula(double h, double last) {
    const double w = h / last, scale = 1 / (1 + 2 * w);
    now = (1 + w) * (1 + w) * scale;
    before = w * w * scale;
    beta = h * (1 + w) * scale;
    error = h * h * (1 + w) * (1 + w) * scale / (6 * w);
  }
  double now, before, beta;
  double error;  // h y''' times this is the formula's
};

TAUT_VECTOR_CLONES
void look_back(std::size_t n, double h, In q, In v, In a, Out q_before, Out v_before) {
  for (std::size_t i = 0; i < n; ++i) {
    q_before[i] = q[i] - h * (v[i] - h / 2 * a[i]);
    v_before[i] = v[i] - h * a[i];
  }
}

/// q where the last accelerations lead, v the velocity that the formula has there, and `known` all
/// that it has for the velocity but beta a.
TAUT_VECTOR_CLONES
void predict(std::size_t n, double h, double last, Formula f, In q, In v, In q_before, In v_before,
             In older, In old, Out known, Out q_next, Out v_next) {
  const double half = h * h / 2, more = h / (3 * last), per_beta = 1 / f.beta;
  for (std::size_t i = 0; i < n; ++i) {
    const double place = q[i] + h * v[i] + half * (old[i] + more * (old[i] - older[i]));
    known[i] = f.now * v[i] - f.before * v_before[i];
    q_next[i] = place;
    v_next[i] = (place - f.now * q[i] + f.before * q_before[i]) * per_beta;
  }
}

TAUT_VECTOR_CLONES
void right_side(std::size_t n, double per_beta, In known, In v, Out a) {
  for (std::size_t i = 0; i < n; ++i) a[i] += (known[i] - v[i]) * per_beta;
}

TAUT_VECTOR_CLONES
void correct(std::size_t n, double per_beta, In x, Out q, Out v) {
  for (std::size_t i = 0; i < n; ++i) {
    q[i] += x[i];
    v[i] += per_beta * x[i];
  }
}

/// The acceleration that the formula has at the end, and what it errs by.
TAUT_VECTOR_CLONES
void errors(std::size_t n, double h, double last, Formula f, In known, In older, In old, In v,
            bool first, Out a, Out error) {
  const double per_beta = 1 / f.beta, ratio = h / last;
  const double of_place = f.error * per_beta * per_beta;
  const double of_speed = first ? 0 : 2 * f.error / (h + last) * per_beta;
  for (std::size_t i = 0; i < n; ++i) {
    a[i] = (v[i] - known[i]) * per_beta;
    const double more = a[i] - old[i];
    error[i] = of_place * more + of_speed * (more - ratio * (old[i] - older[i]));
  }
}

}  // namespace

void BdfStep::make_arrays(Arena& arena) {
  for (Slice* slice : {&older_, &old_, &new_, &x_, &known_, &q_, &v_}) *slice = arena.make();
}

void BdfStep::begin(double h, const double* q, const double* v, const double* a, double* q_before,
                    double* v_before) {
  first_ = true;
  look_back(q_.size(), h, q, v, a, q_before, v_before);
  for (const Slice& slice : {older_, old_}) std::copy_n(a, slice.size(), slice.begin());
}

/// With J = [0 1; -M^-1 K 0], (1/beta^2 + M^-1 K) dq = (what is left of the velocity's equation) /
/// beta. What the formula errs by goes through the same system, which takes from it the waves that
/// it damps.
Outcome BdfStep::attempt(System& system, double time, double h, double last, double memory,
                         const double* q, const double* v, const double* q_before,
                         const double* v_before) {
  const Formula f(h, last);
  const std::size_t size = q_.size();
  predict(size, h, last, f, q, v, q_before, v_before, older_.data(), old_.data(), known_.data(),
          q_.data(), v_.data());
  system.acceleration(time + h, q_.data(), v_.data(), x_.data());
  right_side(size, 1 / f.beta, known_.data(), v_.data(), x_.data());
  system.factor_waves(1 / (f.beta * f.beta));
  system.solve_waves(x_.data());
  correct(size, 1 / f.beta, x_.data(), q_.data(), v_.data());
  const double frequency = system.frequency();
  const double excess = system.keep(time + h, 1 / f.beta, q_.data(), v_.data());
  errors(size, h, last, f, known_.data(), older_.data(), old_.data(), v_.data(), first_,
         new_.data(), x_.data());
  return {.error = system.accumulated(memory, 3 / (h * h), x_.data()),
          .excess = excess,
          .frequency = frequency};
}

void BdfStep::accept(Slice& q, Slice& v) {
  first_ = false;
  q_.swap(q);
  v_.swap(v);
  older_.swap(old_);
  old_.swap(new_);
}

}  // namespace taut::direct
