// The smoothest motion of a hand, within its limits, that leads what hangs by a flat chain through
// given points.
#pragma once

#include <functional>
#include <vector>

#include "sim/choreography/gaussian_sum.h"
#include "sim/choreography/hand_frame.h"
#include "sim/choreography/problem.h"

namespace taut::choreography {

/// Least squares over the coefficients of the free end's curve: how far the waypoints are missed,
/// by how much limits are exceeded, and the hand's jerk, which people's hands keep low (Flash and
/// Hogan, "The coordination of arm movements", Journal of Neuroscience 5, 1985).
class FlatFit {
 public:
  FlatFit(const Choreography& problem, double from);

  /// How many Gaussians the free end's curve is.
  static Eigen::Index gaussians(const Choreography& problem, double from);

  /// The fit by Levenberg and Marquardt's method, from the last one. The first one begins under a
  /// gravity so large that the body hangs, and follows the fit down to the world's: so the chain
  /// stays taut all the way, where a fit at once would stop at motions that it cannot follow. Where
  /// waypoints ask for turns that keep the chain taut by themselves, gravity is the world's at
  /// once. `tick` is called now and then.
  void solve(const std::vector<Vec3>& aims, const std::function<void()>& tick);

  /// The hand's keys after `from`, at rest at the last.
  std::vector<PathKey> keys() const;
  /// The least tension of the body's link (N).
  double least_tension() const;

 private:
  /// An instant at which the motion counts.
  struct Instant {
    double time = 0;  // s
    GaussianSum::Local basis;
    std::size_t waypoint = 0;  // of it, or none: of the hand's motion
    double hangs = 1;          // share of the gravity that is too large, in its logarithm
  };
  /// Instant::hangs at a time: 0 where the waypoints turn faster than gravity could make them, and
  /// so keep the chain taut by themselves; linear from one waypoint to the next.
  double hangs_at(double time) const;
  /// A smooth curve with the hand still, and the body pointing away from it at each waypoint.
  void start();
  /// Under so many of the world's gravity, to this relative change of the cost, which it returns.
  double fit(double gravities, double fine);
  int steps_of(double longest) const;
  TaylorSeries free_end(const GaussianSum::Local& basis, const Eigen::VectorXd& coefficients) const;
  /// Of the body from what leads it, a line from the pivot to the chain's end (m).
  double clearance(const FlatMotion& motion) const;
  Eigen::VectorXd residuals(const Instant& instant, const TaylorSeries& free_end) const;
  /// The root of the residuals' squares, of all instants; infinite where the chain has no motion.
  double cost(const Eigen::VectorXd& coefficients) const;
  /// J'J and J'r of the residuals r.
  void linearize(Eigen::MatrixXd& normal, Eigen::VectorXd& slope) const;

  const Choreography& problem_;
  FlatChain chain_, last_;  // the whole, and the body's link alone
  HandFrame hand_;
  double from_;                   // s
  Vec3 rest_ = Vec3::Zero();      // m, of the free end
  double along_ = 1;              // of the point, as a share of the body's link
  double weight_ = 0, jerk_ = 0;  // N, of the body; m/s^3
  double gravities_ = 1;          // under which the fit is
  GaussianSum curve_;
  std::vector<Instant> instants_;
  std::vector<Vec3> aims_;
  std::function<void()> tick_;
  Eigen::VectorXd coefficients_;
  bool fitted_ = false;
};

}  // namespace taut::choreography
