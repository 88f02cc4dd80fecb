#include "sim/choreography/gaussian_sum.h"

#include <algorithm>
#include <cmath>

namespace taut::choreography {

GaussianSum GaussianSum::between(double from, double until, double spacing) {
  const double room = (until - from) / spacing - 2 * kSupport;
  if (room < 0) return {from, spacing, 0};
  return {from + kSupport * spacing, spacing, static_cast<Eigen::Index>(std::floor(room)) + 1};
}

GaussianSum::Local GaussianSum::at(double time, Eigen::Index columns) const {
  const double place = (time - first) / spacing;
  const auto clamped = [&](double index) {
    return static_cast<Eigen::Index>(std::clamp(index, 0.0, static_cast<double>(count)));
  };
  Local local{clamped(std::ceil(place - kSupport)), {}};
  const Eigen::Index end = std::max(local.begin, clamped(std::floor(place + kSupport) + 1));
  local.series.resize(end - local.begin, columns);
  for (Eigen::Index i = 0; i < local.series.rows(); ++i) {
    // g = exp(-x^2 / 2) has g' = -x g, with x in standard deviations.
    const double x = place - static_cast<double>(local.begin + i);
    auto g = local.series.row(i);
    g[0] = std::exp(-x * x / 2);
    for (Eigen::Index k = 0; k + 1 < columns; ++k) {
      g[k + 1] = -(x * g[k] + (k > 0 ? g[k - 1] : 0)) / static_cast<double>(k + 1);
    }
    double power = 1;
    for (Eigen::Index k = 0; k < columns; ++k, power /= spacing) g[k] *= power;
  }
  return local;
}

}  // namespace taut::choreography
