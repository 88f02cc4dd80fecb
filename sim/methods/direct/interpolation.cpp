// The state at a time within the last step.
#include "sim/methods/direct/integrator.h"
#include "sim/methods/direct/system/vector.h"

namespace taut::direct {
namespace {

/// The state between two others, at the share s of the way that takes h, by Hermite's polynomial:
/// of degree 3 or, with the accelerations at both, 5.
template <bool kWithAccelerations>
[[gnu::always_inline]] inline void hermite(std::size_t n, double h, double s,
                                           const double* const (&first)[3],
                                           const double* const (&last)[3], double* __restrict q,
                                           double* __restrict rate) {
  const double half = h * h / 2;
  const double bump = s * s * (1 - s) * (1 - s), rise = 2 * s * (1 - s) * (1 - 2 * s);
  for (std::size_t i = 0; i < n; ++i) {
    const double start = h * first[1][i], end = h * last[1][i], gone = last[0][i] - first[0][i];
    const double c2 = 3 * gone - 2 * start - end, c3 = start + end - 2 * gone;
    double place = first[0][i] + s * (start + s * (c2 + s * c3));
    double way = start + s * (2 * c2 + s * 3 * c3);
    if constexpr (kWithAccelerations) {
      const double u = half * first[2][i] - c2, v = half * (last[2][i] - first[2][i]) - 3 * c3;
      place += bump * (u + s * v);
      way += rise * (u + s * v) + bump * v;
    }
    q[i] = place;
    rate[i] = way / h;
  }
}

TAUT_VECTOR_CLONES
void cubic(std::size_t n, double h, double s, const double* const (&first)[3],
           const double* const (&last)[3], double* q, double* rate) {
  hermite<false>(n, h, s, first, last, q, rate);
}

TAUT_VECTOR_CLONES
void quintic(std::size_t n, double h, double s, const double* const (&first)[3],
             const double* const (&last)[3], double* q, double* rate) {
  hermite<true>(n, h, s, first, last, q, rate);
}

}  // namespace

/// The state at `time` within the last step, by Hermite's polynomial. Accelerations count in it
/// where Adams follows every wave; the implicit scheme passes over them.
void Integrator::interpolate(double time, const double* first_acceleration,
                             const double* last_acceleration) {
  const double h = time_ - before_, s = (time - before_) / h;
  const double* const first[] = {q_before_.data(), rate_before_.data(), first_acceleration};
  const double* const last[] = {q_.data(), rate_.data(), last_acceleration};
  (first_acceleration ? quintic : cubic)(q_.size(), h, s, first, last, q_between_.data(),
                                         rate_between_.data());
  if (!system_.project(time, q_between_.data(), rate_between_.data())) throw StepTooSmall{time};
  if (system_.projection_cost() > 0) fresh_ = false;  // that may have changed the tensions
}

}  // namespace taut::direct
