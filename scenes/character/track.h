// Values sampled evenly over time: filters over all of it, and smooth reading between the samples.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>

namespace taut::scenes {

/// Samples in columns, from time 0 on, `rate` a second. All filters take the first and the last
/// sample to hold for ever.
class Track {
 public:
  Track(Eigen::MatrixXd samples, double rate) : samples_(std::move(samples)), rate_(rate) {}
  /// Samples `value` over [0, duration].
  static Track sample(double duration, double rate,
                      const std::function<Eigen::VectorXd(double)>& value);

  Eigen::Index count() const { return samples_.cols(); }
  double time(Eigen::Index i) const { return static_cast<double>(i) / rate_; }
  double rate() const { return rate_; }
  const Eigen::MatrixXd& samples() const { return samples_; }
  Eigen::MatrixXd& samples() { return samples_; }
  auto operator[](Eigen::Index i) const { return samples_.col(i); }

  /// The value at any time: cubic through the samples, with continuous rate.
  Eigen::VectorXd at(double time) const;
  /// The track of a critically damped follower: a mean delay of `lag` (s).
  Track lagged(double lag) const;
  /// Convolved with a Gaussian of that standard deviation (s): no delay.
  Track smoothed(double deviation) const;
  /// Rates per second, by central differences.
  Track rates() const;
  /// The same values `shift` seconds earlier.
  Track ahead(double shift) const;

 private:
  Eigen::Index nearest(Eigen::Index i) const;

  Eigen::MatrixXd samples_;
  double rate_;
};

// Shapes of costs and limits that the parts of a character share.

inline constexpr double degree = M_PI / 180;  // rad

inline double squared(double x) {
  return x * x;
}
/// How far a value is beyond its limit; 0 below it.
inline double beyond(double value, double limit) {
  return std::max(0.0, value - limit);
}
/// From 0 to 1 as x does, with level ends.
inline double smoothstep(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
/// x for small values, which approaches the limit for large ones.
inline double soft(double x, double limit) {
  return limit * std::tanh(x / limit);
}

}  // namespace taut::scenes
