// Motions between two keys as glTF's cubic splines, fitted to the states between them.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace taut::exporting {

/// The slopes (per second) of a cubic from one key to the next: as it leaves the one and comes to
/// the other.
template <int kSize>
struct Slopes {
  using Value = Eigen::Matrix<double, kSize, 1>;
  Value leaving, arriving;
};

/// The weights of a cubic's key values and slopes at the share `u` of an interval of `span` s
/// (glTF 2.0, appendix C).
struct HermiteWeights {
  double first, leaving, arriving, last;
};
HermiteWeights hermite_weights(double u, double span);

/// The slopes with which a cubic from the first to the last value comes nearest to those between
/// (least squares). `times` rise. Where too few are between to tell, the straight line.
template <int kSize>
Slopes<kSize> fit_slopes(std::span<const double> times,
                         std::span<const Eigen::Matrix<double, kSize, 1>> values) {
  using Value = Eigen::Matrix<double, kSize, 1>;
  const double start = times.front(), span = times.back() - start;
  const Value line = (values.back() - values.front()) / span;
  // Unknowns: by how much the slopes differ from the line's. A little weight on that decides where
  // nothing else does.
  constexpr double kTowardsLine = 1e-6;
  const double towards = kTowardsLine * span * span;
  double a = towards, b = 0, d = towards;
  Value p = Value::Zero(), q = Value::Zero();
  for (std::size_t i = 1; i + 1 < times.size(); ++i) {
    const double u = (times[i] - start) / span;
    const HermiteWeights w = hermite_weights(u, span);
    const Value rest = values[i] - values.front() - u * span * line;
    a += w.leaving * w.leaving;
    b += w.leaving * w.arriving;
    d += w.arriving * w.arriving;
    p += w.leaving * rest;
    q += w.arriving * rest;
  }
  const double determinant = a * d - b * b;
  return {line + (d * p - b * q) / determinant, line + (a * q - b * p) / determinant};
}

/// The cubic's value at the share `u` of the interval.
template <int kSize>
Eigen::Matrix<double, kSize, 1> on_cubic(const Eigen::Matrix<double, kSize, 1>& first,
                                         const Eigen::Matrix<double, kSize, 1>& last,
                                         const Slopes<kSize>& slopes, double u, double span) {
  const HermiteWeights w = hermite_weights(u, span);
  return w.first * first + w.leaving * slopes.leaving + w.arriving * slopes.arriving +
         w.last * last;
}

}  // namespace taut::exporting
