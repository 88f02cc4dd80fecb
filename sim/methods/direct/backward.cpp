#include "sim/methods/direct/backward.h"

#include <algorithm>
#include <cmath>
#include <limits>

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
void look_back(std::size_t n, double h, In q, In rate, In a, Out q_before, Out rate_before) {
  for (std::size_t i = 0; i < n; ++i) {
    q_before[i] = q[i] - h * (rate[i] - h / 2 * a[i]);
    rate_before[i] = rate[i] - h * a[i];
  }
}

TAUT_VECTOR_CLONES
void into_chart(std::size_t n, In q, In q_before, In rate_before, Out x, Out y) {
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = q_before[i] - q[i];
    y[i] = rate_before[i];
  }
}

/// From the last state in the chart about q: x where the accelerations lead, y the rate that the
/// formula has there, and `known` all that it has for the rate but beta f.
TAUT_VECTOR_CLONES
void predict(std::size_t n, double h, double last, Formula f, In rate, In older, In old, Out x,
             Out y, Out known, Out q_next, Out rate_next) {
  const double half = h * h / 2, more = h / (3 * last), per_beta = 1 / f.beta;
  for (std::size_t i = 0; i < n; ++i) {
    const double place = h * rate[i] + half * (old[i] + more * (old[i] - older[i]));
    known[i] = f.now * rate[i] - f.before * y[i];
    q_next[i] = place;
    rate_next[i] = y[i] = (place + f.before * x[i]) * per_beta;
    x[i] = place;
  }
}

TAUT_VECTOR_CLONES
void right_side(std::size_t n, double per_beta, In known, In y, Out a) {
  for (std::size_t i = 0; i < n; ++i) a[i] += (known[i] - y[i]) * per_beta;
}

/// Takes the change of x in `a`, and leaves there the acceleration that the formula has at the end;
/// in x and y the errors, as right sides of the Jacobian's system. Returns the largest change.
TAUT_VECTOR_CLONES
double correct(std::size_t n, double h, double last, Formula f, In known, In older, In old, Out a,
               Out x, Out y, Out q_next, Out rate_next) {
  const double per_beta = 1 / f.beta, ratio = h / last;
  const double ex = f.error * per_beta * per_beta, ey = 2 * f.error / (h + last) * per_beta;
  const double most = largest(n, a);
  for (std::size_t i = 0; i < n; ++i) {
    q_next[i] = x[i] + a[i];
    rate_next[i] = y[i] + per_beta * a[i];
    a[i] = (rate_next[i] - known[i]) * per_beta;
    const double more = a[i] - old[i];
    const double bend = ey * (more - ratio * (old[i] - older[i]));
    x[i] = ex * more + bend;
    y[i] = per_beta * bend;
  }
  return most;
}

}  // namespace

void BackwardStep::make_arrays(Arena& arena) {
  for (Slice* slice : {&older_, &old_, &new_, &x_, &y_, &known_, &q_, &rate_}) {
    *slice = arena.make();
  }
}

void BackwardStep::begin(double h, const double* q, const double* rate, const double* acceleration,
                         double* q_before, double* rate_before) {
  look_back(q_.size(), h, q, rate, acceleration, q_before, rate_before);
  for (const Slice& known : {older_, old_}) std::copy_n(acceleration, known.size(), known.begin());
}

/// With J = [0 1; L 0], (1/beta^2 - L) dx = (what is left of the rate's equation) / beta. What the
/// formula errs by goes through the same system, which takes from it the waves that it damps.
BackwardStep::Outcome BackwardStep::attempt(Motion& motion, double time, double h, double last,
                                            const double* q, const double* rate,
                                            const double* q_before, const double* rate_before) {
  constexpr double kOutside = std::numeric_limits<double>::infinity();
  const Formula f(h, last);
  const std::size_t size = q_.size();
  double *x = x_.data(), *y = y_.data(), *a = new_.data();
  into_chart(size, q, q_before, rate_before, x, y);
  motion.across(q, x);
  motion.across(q, y);
  predict(size, h, last, f, rate, older_.data(), old_.data(), x, y, known_.data(), q_.data(),
          rate_.data());
  if (!motion.lift(q, q_.data(), rate_.data())) return {kOutside, kOutside};
  motion.acceleration(time + h, q_.data(), rate_.data(), a);
  motion.across(q, a);
  right_side(size, 1 / f.beta, known_.data(), y, a);
  motion.freeze(1 / (f.beta * f.beta));
  motion.solve_frozen(a);
  motion.across(q, a);
  const double correction = correct(size, h, last, f, known_.data(), older_.data(), old_.data(), a,
                                    x, y, q_.data(), rate_.data());
  if (!motion.lift(q, q_.data(), rate_.data())) return {kOutside, kOutside};
  motion.solve_frozen(x, y);
  return {motion.error(x, y), correction};
}

void BackwardStep::accept(Slice& q, Slice& rate) {
  q_.swap(q);
  rate_.swap(rate);
  older_.swap(old_);
  old_.swap(new_);
}

}  // namespace taut::direct
