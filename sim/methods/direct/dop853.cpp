#include "sim/methods/direct/dop853.h"

#include <cmath>
#include <utility>

namespace taut::direct {
namespace {

using Row = std::array<double, kStages>;

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
constexpr Row kPositionWeight = position_row(kDop853.weight);
constexpr Row kPositionError5 = position_row(kDop853.error5);
constexpr Row kPositionError3 = position_row(kDop853.error3);

/// sum_k row[k] a_k[i] over the stages whose weight is not zero, known when compiled.
template <Row kRow, int kCount, int k = 0>
[[gnu::always_inline]] inline double combine(const double* const* a, std::size_t i) {
  if constexpr (k == kCount) {
    return 0;
  } else if constexpr (kRow[k] == 0) {
    return combine<kRow, kCount, k + 1>(a, i);
  } else {
    return kRow[k] * a[k][i] + combine<kRow, kCount, k + 1>(a, i);
  }
}

template <int kStage>
void stage_state(std::size_t n, double h, const double* q, const double* rate,
                 const double* const* a, double* q_out, double* rate_out) {
  constexpr Row position = kPositionStage[kStage], velocity = kDop853.stage[kStage];
  const double c = kDop853.node[kStage];
  for (std::size_t i = 0; i < n; ++i) {
    q_out[i] = q[i] + h * (c * rate[i] + h * combine<position, kStage>(a, i));
    rate_out[i] = rate[i] + h * combine<velocity, kStage>(a, i);
  }
}

}  // namespace

Dop853Step::Dop853Step(std::size_t size)
    : size_(size),
      accelerations_((kStages - 1) * size),
      q_(size),
      rate_(size),
      error_q_(size),
      error_rate_(size) {}

double Dop853Step::attempt(Motion& motion, double time, double h, const double* q,
                           const double* rate, const double* first) {
  const double* a[kStages];
  a[0] = first;
  for (int s = 1; s < kStages; ++s) a[s] = accelerations_.data() + (s - 1) * size_;
  const auto stages = [&]<int... s>(std::integer_sequence<int, s...>) {
    ((stage_state<s + 1>(size_, h, q, rate, a, q_.data(), rate_.data()),
      motion.acceleration(time + kDop853.node[s + 1] * h, q_.data(), rate_.data(),
                          accelerations_.data() + s * size_)),
     ...);
  };
  stages(std::make_integer_sequence<int, kStages - 1>());

  for (std::size_t i = 0; i < size_; ++i) {
    q_[i] = q[i] + h * (rate[i] + h * combine<kPositionWeight, kStages>(a, i));
    rate_[i] = rate[i] + h * combine<kDop853.weight, kStages>(a, i);
    error_q_[i] = h * h * combine<kPositionError5, kStages>(a, i);
    error_rate_[i] = h * combine<kDop853.error5, kStages>(a, i);
  }
  const double error5 = motion.error(q, error_q_.data(), error_rate_.data());
  for (std::size_t i = 0; i < size_; ++i) {
    error_q_[i] = h * h * combine<kPositionError3, kStages>(a, i);
    error_rate_[i] = h * combine<kDop853.error3, kStages>(a, i);
  }
  const double error3 = motion.error(q, error_q_.data(), error_rate_.data());
  // Hairer's blend: of order 8 where both estimates behave.
  const double blend = std::hypot(error5, 0.1 * error3);
  return blend > 0 ? error5 * error5 / blend : blend;
}

}  // namespace taut::direct
