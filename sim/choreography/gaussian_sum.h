// Curves that are sums of Gaussians at even times: analytic, so that every derivative exists, and
// each coefficient bends its own part of the curve alone.
#pragma once

#include <vector>

#include "sim/choreography/flat_chain.h"

namespace taut::choreography {

/// Gaussians of standard deviation `spacing` (s) at first + k spacing, for k below `count`.
struct GaussianSum {
  double first = 0, spacing = 1;  // s
  Eigen::Index count = 0;

  /// Beyond so many spacings a Gaussian counts as zero, it and its derivatives.
  static constexpr double kSupport = 6;
  /// From rest at `from` to rest at `until`; no Gaussians where that is too short for one.
  static GaussianSum between(double from, double until, double spacing);

  /// Of the Gaussians that are not zero at `time`, beginning with `begin`: rows of Taylor series.
  struct Local {
    Eigen::Index begin = 0;
    Eigen::MatrixXd series;
  };
  Local at(double time, Eigen::Index columns) const;
};

}  // namespace taut::choreography
