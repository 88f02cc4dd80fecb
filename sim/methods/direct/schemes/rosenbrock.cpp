#include "sim/methods/direct/schemes/rosenbrock.h"

#include <algorithm>
#include <array>
#include <limits>

#include "sim/methods/direct/schemes/arena.h"
#include "sim/methods/direct/system/links.h"

namespace taut::direct {
namespace {

constexpr int kStages = RosenbrockStep::kStages;
using Row = std::array<double, kStages>;
using Table = std::array<Row, kStages>;

constexpr double kGamma = 4.3586652150845900e-1;
constexpr Table kAlpha = {
    {{}, {8.7173304301691801e-1}, {8.4457060015369423e-1, -1.1299064236484185e-1}, {0, 0, 1}}};
constexpr Table kGammas = {
    {{kGamma},
     {-8.7173304301691801e-1, kGamma},
     {-9.0338057013044082e-1, 5.4180672388095326e-2, kGamma},
     {2.4212380706095346e-1, -1.2232505839045147, 5.4526025533510214e-1, kGamma}}};
constexpr Row kWeight = {2.4212380706095346e-1, -1.2232505839045147, 1.5452602553351020, kGamma};
constexpr Row kEmbedded = {3.7810903145819369e-1, -9.6042292212423178e-2, 0.5,
                           2.1793326075422950e-1};

constexpr Table inverse(const Table& lower) {
  Table out{};
  for (int c = 0; c < kStages; ++c) {
    for (int r = c; r < kStages; ++r) {
      double sum = r == c ? 1 : 0;
      for (int k = c; k < r; ++k) sum -= lower[r][k] * out[k][c];
      out[r][c] = sum / lower[r][r];
    }
  }
  return out;
}

constexpr Row times(const Row& row, const Table& table) {
  Row out{};
  for (int c = 0; c < kStages; ++c) {
    for (int k = 0; k < kStages; ++k) out[c] += row[k] * table[k][c];
  }
  return out;
}

// In terms of U = Gamma K no product with the Jacobian is left: (1/(gamma h) - J) U_i =
// f(y + sum_j a_ij U_j) - sum_{j<i} c_ij U_j / h, c the inverse of Gamma; Hairer and Wanner,
// volume II, section IV.7.
constexpr Table kC = inverse(kGammas);
constexpr Table kA = {
    {times(kAlpha[0], kC), times(kAlpha[1], kC), times(kAlpha[2], kC), times(kAlpha[3], kC)}};
constexpr Row kM = times(kWeight, kC), kMEmbedded = times(kEmbedded, kC);
constexpr Row kError = {kM[0] - kMEmbedded[0], kM[1] - kMEmbedded[1], kM[2] - kMEmbedded[2],
                        kM[3] - kMEmbedded[3]};
constexpr Row kNode = {0, kAlpha[1][0], kAlpha[2][0] + kAlpha[2][1], 1};

// The arrays of a step: increments of x and of its rate, by stage.
using Stages = const double* const*;

template <int s>
[[gnu::always_inline]] inline void stage_loop(std::size_t n, const double* rate, Stages dx,
                                              Stages dy, double* __restrict x,
                                              double* __restrict y) {
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = combine<kA[s], s>(dx, i);
    y[i] = rate[i] + combine<kA[s], s>(dy, i);
  }
}

TAUT_VECTOR_CLONES
void stage_state(int stage, std::size_t n, const double* rate, Stages dx, Stages dy, double* x,
                 double* y) {
  if (stage == 1) stage_loop<1>(n, rate, dx, dy, x, y);
  if (stage == 2) stage_loop<2>(n, rate, dx, dy, x, y);
  if (stage == 3) stage_loop<3>(n, rate, dx, dy, x, y);
}

// With J = [0 1; L 0] and sigma = 1/(gamma h): (sigma^2 - L) dx = r_y + sigma r_x and
// dy = sigma dx - r_x, r the right sides. Leaves the right side of the first in dx, r_x in dy.
template <int s>
[[gnu::always_inline]] inline void right_loop(std::size_t n, double h, const double* y,
                                              const double* a, Stages dx, Stages dy,
                                              double* __restrict dx_out,
                                              double* __restrict dy_out) {
  const double sigma = 1 / (kGamma * h), per_step = 1 / h;
  for (std::size_t i = 0; i < n; ++i) {
    const double rx = y[i] - per_step * combine<kC[s], s>(dx, i);
    dx_out[i] = a[i] - per_step * combine<kC[s], s>(dy, i) + sigma * rx;
    dy_out[i] = rx;
  }
}

TAUT_VECTOR_CLONES
void right_side(int stage, std::size_t n, double h, const double* y, const double* a, Stages dx,
                Stages dy, double* dx_out, double* dy_out) {
  if (stage == 0) right_loop<0>(n, h, y, a, dx, dy, dx_out, dy_out);
  if (stage == 1) right_loop<1>(n, h, y, a, dx, dy, dx_out, dy_out);
  if (stage == 2) right_loop<2>(n, h, y, a, dx, dy, dx_out, dy_out);
  if (stage == 3) right_loop<3>(n, h, y, a, dx, dy, dx_out, dy_out);
}

TAUT_VECTOR_CLONES
void finish_stage(std::size_t n, double sigma, const double* __restrict dx, double* __restrict dy) {
  for (std::size_t i = 0; i < n; ++i) dy[i] = sigma * dx[i] - dy[i];
}

TAUT_VECTOR_CLONES
void end_state(std::size_t n, const double* rate, Stages dx, Stages dy, double* __restrict x,
               double* __restrict y, double* __restrict ex, double* __restrict ey) {
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = combine<kM, kStages>(dx, i);
    y[i] = rate[i] + combine<kM, kStages>(dy, i);
    ex[i] = combine<kError, kStages>(dx, i);
    ey[i] = combine<kError, kStages>(dy, i);
  }
}

}  // namespace

void RosenbrockStep::make_results(Arena& arena) {
  for (Slice* slice : {&q_, &rate_}) *slice = arena.make();
}

void RosenbrockStep::make_workspace(Arena& arena) {
  for (Slice& slice : dx_) slice = arena.make();
  for (Slice& slice : dy_) slice = arena.make();
  for (Slice* slice : {&chart_rate_, &acceleration_, &error_q_, &error_rate_}) {
    *slice = arena.make();
  }
}

StepError RosenbrockStep::attempt(System& system, double time, double h, const double* q,
                                  const double* rate, const double* first) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  constexpr StepError kOutside = {kInfinite, kInfinite, kInfinite};
  double *dx[kStages], *dy[kStages];
  for (int s = 0; s < kStages; ++s) {
    dx[s] = dx_[s].data();
    dy[s] = dy_[s].data();
  }
  const std::size_t size = q_.size();
  const double sigma = 1 / (kGamma * h);
  system.factor(sigma * sigma);
  for (int s = 0; s < kStages; ++s) {
    const double* y = rate;
    if (s == 0) {
      std::copy(first, first + size, acceleration_.begin());
    } else {
      stage_state(s, size, rate, dx, dy, q_.data(), rate_.data());
      std::copy(rate_.begin(), rate_.end(), chart_rate_.begin());
      y = chart_rate_.data();
      if (!system.retract(q, q_.data(), rate_.data())) return kOutside;
      system.acceleration(time + kNode[s] * h, q_.data(), rate_.data(), acceleration_.data());
    }
    system.to_tangent(q, acceleration_.data());
    right_side(s, size, h, y, acceleration_.data(), dx, dy, dx[s], dy[s]);
    system.solve_factored(dx[s]);
    system.to_tangent(q, dx[s]);
    finish_stage(size, sigma, dx[s], dy[s]);
  }
  end_state(size, rate, dx, dy, q_.data(), rate_.data(), error_q_.data(), error_rate_.data());
  if (!system.retract(q, q_.data(), rate_.data())) return kOutside;
  StepError error;
  error.all = system.error(error_q_.data(), error_rate_.data());
  error.passed_over = system.displacement(error_q_.data());
  for (Slice* part : {&error_q_, &error_rate_}) {
    for (double& x : *part) x *= sigma * sigma;
    system.solve_factored(part->data());
    system.to_tangent(q, part->data());
  }
  error.followed = system.error(error_q_.data(), error_rate_.data());
  return error;
}

}  // namespace taut::direct
