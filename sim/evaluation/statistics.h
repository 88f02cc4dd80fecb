// Statistics that compare two motions once neither is predictable: energy, stretch of links, and
// speeds of points.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sim/motion/types.h"

namespace taut::study {

/// The speeds of points from frame to frame.
class Speeds {
 public:
  /// Where the points are in the next frame, `dt` (s) after the one before.
  void add(const std::vector<Vec3>& points, double dt);
  /// The next frame does not follow on the one before.
  void pause() { last_.clear(); }
  /// All of them so far (m/s), rising.
  std::vector<double> sorted() const;

 private:
  std::vector<Vec3> last_;
  std::vector<double> speeds_;
};

/// How far energies (J) are apart.
class EnergyDifference {
 public:
  /// `more` (J) than the other's in one more frame.
  void add(double more);
  double largest() const { return largest_; }
  double of_means() const;

 private:
  double largest_ = 0, sum_ = 0;
  std::size_t frames_ = 0;
};

/// The Kolmogorov-Smirnov distance of two samples, both rising: the largest difference of the
/// shares that lie below any value. Values that differ by at most `same` count as equal.
double distribution_distance(std::span<const double> a, std::span<const double> b, double same);

}  // namespace taut::study
