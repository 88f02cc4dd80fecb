#include "sim/methods/direct/schemes/dop853.h"

#include <cmath>
#include <utility>

#include "sim/methods/direct/schemes/arena.h"
#include "sim/methods/direct/system/links.h"

namespace taut::direct {
namespace {

using Row = Dop853::Row;

/// Weights of the accelerations in q where `row` are those of the rates: sum_j row_j stage_jk.
constexpr Row position_row(const Row& row) {
  Row out{};
  for (int k = 0; k < kStages; ++k) {
    for (int j = 0; j < kStages; ++j) out[k] += row[j] * kDop853.stage[j][k];
  }
  return out;
}

constexpr auto kPositionStage = [] {
  std::array<Row, kStages> rows{};
  for (int i = 0; i < kStages; ++i) rows[i] = position_row(kDop853.stage[i]);
  return rows;
}();
constexpr Row kWeight = kDop853.stage[kStages], kPositionWeight = position_row(kWeight);
constexpr Row kPositionError5 = position_row(kDop853.error5);
constexpr Row kPositionError3 = position_row(kDop853.error3);

template <int kStage>
[[gnu::always_inline]] inline void stage_loop(std::size_t n, double h, const double* q,
                                              const double* rate, const double* const* a,
                                              double* __restrict q_out,
                                              double* __restrict rate_out) {
  constexpr double c = kDop853.node[kStage];
  for (std::size_t i = 0; i < n; ++i) {
    q_out[i] = q[i] + h * (c * rate[i] + h * combine<kPositionStage[kStage], kStage>(a, i));
    rate_out[i] = rate[i] + h * combine<kDop853.stage[kStage], kStage>(a, i);
  }
}

template <int... kBefore>
[[gnu::always_inline]] inline void stage_loops(std::integer_sequence<int, kBefore...>, int stage,
                                               std::size_t n, double h, const double* q,
                                               const double* rate, const double* const* a,
                                               double* q_out, double* rate_out) {
  (...,
   (stage == kBefore + 1 ? stage_loop<kBefore + 1>(n, h, q, rate, a, q_out, rate_out) : void()));
}

/// The state at a stage from the accelerations of those before it.
TAUT_VECTOR_CLONES
void stage_state(int stage, std::size_t n, double h, const double* q, const double* rate,
                 const double* const* a, double* q_out, double* rate_out) {
  stage_loops(std::make_integer_sequence<int, kStages - 1>(), stage, n, h, q, rate, a, q_out,
              rate_out);
}

TAUT_VECTOR_CLONES
void end_state(std::size_t n, double h, const double* q, const double* rate, const double* const* a,
               double* __restrict q_out, double* __restrict rate_out) {
  for (std::size_t i = 0; i < n; ++i) {
    q_out[i] = q[i] + h * (rate[i] + h * combine<kPositionWeight, kStages>(a, i));
    rate_out[i] = rate[i] + h * combine<kWeight, kStages>(a, i);
  }
}

template <Row kPosition, Row kRate>
[[gnu::always_inline]] inline void error_loop(std::size_t n, double h, const double* const* a,
                                              double* __restrict q_out,
                                              double* __restrict rate_out) {
  for (std::size_t i = 0; i < n; ++i) {
    q_out[i] = h * h * combine<kPosition, kStages>(a, i);
    rate_out[i] = h * combine<kRate, kStages>(a, i);
  }
}

TAUT_VECTOR_CLONES
void error_of_order_5(std::size_t n, double h, const double* const* a, double* q, double* rate) {
  error_loop<kPositionError5, kDop853.error5>(n, h, a, q, rate);
}

TAUT_VECTOR_CLONES
void error_of_order_3(std::size_t n, double h, const double* const* a, double* q, double* rate) {
  error_loop<kPositionError3, kDop853.error3>(n, h, a, q, rate);
}

}  // namespace

void Dop853Step::make_results(Arena& arena) {
  for (Slice* slice : {&q_, &rate_}) *slice = arena.make();
}

void Dop853Step::make_workspace(Arena& arena) {
  for (int s = 1; s < kStages; ++s) accelerations_[s] = arena.make();
  for (Slice* slice : {&error_q_, &error_rate_}) *slice = arena.make();
}

double Dop853Step::attempt(System& system, double time, double h, const double* q,
                           const double* rate, const double* first) {
  const double* a[kStages];
  a[0] = first;
  for (int s = 1; s < kStages; ++s) a[s] = accelerations_[s].data();
  const std::size_t size = q_.size();
  for (int s = 1; s < kStages; ++s) {
    stage_state(s, size, h, q, rate, a, q_.data(), rate_.data());
    system.acceleration(time + kDop853.node[s] * h, q_.data(), rate_.data(),
                        accelerations_[s].data());
  }
  end_state(size, h, q, rate, a, q_.data(), rate_.data());
  error_of_order_5(size, h, a, error_q_.data(), error_rate_.data());
  system.to_tangent(q, error_q_.data());
  system.to_tangent(q, error_rate_.data());
  const double error5 = system.error(error_q_.data(), error_rate_.data());
  error_of_order_3(size, h, a, error_q_.data(), error_rate_.data());
  system.to_tangent(q, error_q_.data());
  system.to_tangent(q, error_rate_.data());
  const double error3 = system.error(error_q_.data(), error_rate_.data());
  // Hairer's blend: of order 8 where both estimates behave.
  const double blend = std::hypot(error5, 0.1 * error3);
  return blend > 0 ? error5 * error5 / blend : blend;
}

}  // namespace taut::direct
