// The path of a hand that leads a taut chain through waypoints: the chain as a differentially flat
// system, and the smoothest motion of its driven end within the limits of the hand.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/interventions/interventions.h"
#include "sim/motion/types.h"
#include "sim/world/world.h"

namespace taut::choreography {

// A taut chain that hangs from a driven end, as a differentially flat system: the motion of its
// free end gives, link by link, the tensions, every particle and the driven end in closed form.
//
// Of a particle's acceleration a, what the links have to pull is m (a - g); so the last particle's
// motion gives the direction and the tension of the last link, that link the next particle, and so
// on: each link takes two more derivatives. Fliess, Levine, Martin, Rouchon, "Flatness and defect
// of non-linear systems", International Journal of Control 61, 1995; Murray, "Trajectory generation
// for a towed cable system using differential flatness", IFAC World Congress, 1996; Petit and
// Rouchon, "Flatness of heavy chain systems", SIAM Journal on Control and Optimization 40, 2001.

/// A Taylor series in time: column k is the k-th derivative over k!, m/s^k.
using TaylorSeries = Eigen::Matrix3Xd;

/// The series of the unit vector along `series`, which is not zero at the instant itself.
TaylorSeries unit_series(const TaylorSeries& series);
/// The series of the second derivative, two columns shorter.
TaylorSeries second_derivative(const TaylorSeries& series);

/// Particles on rigid links, numbered from the free end. A body that hangs at the end is one more
/// link (see Stick), whose free end is its centre of oscillation.
struct FlatChain {
  Vec3 gravity = Vec3(0, -9.81, 0);  // m/s^2
  std::vector<double> mass;          // kg, of the particle at the free end of each link
  std::vector<double> length;        // m, of each link

  /// Columns that the free end's series needs so that the driven end's has `columns`.
  Eigen::Index columns(Eigen::Index columns) const {
    return columns + 2 * static_cast<Eigen::Index>(length.size());
  }
};

struct FlatMotion {
  std::vector<TaylorSeries> particles;  // from the free end to the driven one, ever shorter
  std::vector<double> tension;          // N, of each link
};

/// Under so many times the chain's gravity. Exact to rounding; no number is finite where a link's
/// pull is zero.
FlatMotion flat_motion(const FlatChain& chain, const TaylorSeries& free_end, double gravities = 1);

/// Why the motion of the body and of the connector that it hangs by does not follow from that of
/// one of its points, or empty. Beside what why_no_link() says, the connector's other end has to be
/// driven, and the body to have the same moment about every axis across its line. Links that only
/// pull count as rigid: while the chain is taut they are.
std::string why_not_flat(const World& world, const Timeline& timeline, std::size_t body);

/// The connector that the body hangs by, and its hold on the body.
const Connector& hanging_chain(const World& world, std::size_t body);
const Hold& hanging_hold(const World& world, std::size_t body);

/// The chain that ends in that body, for which why_not_flat() has no reason.
FlatChain flat_chain(World world, std::size_t body);

/// The same with at most so many even links beside the body's: each mass is shared by the two
/// particles that it lies between, so that the chain's moment about the driven end stays.
FlatChain coarser(const FlatChain& chain, std::size_t links);

// The problem of a choreography: the waypoints, and the limits of the hand.

/// A place that is to be passed.
struct Waypoint {
  double time = 0;               // s
  Vec3 position = Vec3::Zero();  // m
};

/// Limits of the hand's path: a hundredth beyond costs the fit as much as a waypoint
/// missed by 0.3 mm. HandPath tells what was kept.
struct HandLimits {
  Vec3 shoulder = Vec3::Zero();                                   // m
  double reach = std::numeric_limits<double>::infinity();         // m, from the shoulder
  double speed = std::numeric_limits<double>::infinity();         // m/s
  double acceleration = std::numeric_limits<double>::infinity();  // m/s^2
  /// m, between a line from the pivot to the chain's end, and the body's from where it hangs to the
  /// point; counts where there is a pivot.
  double clearance = 0;
};

/// The problem. The path that drives the other end of the body's connector rests from its last key
/// on; there the hand's path begins, and there it ends.
struct Choreography {
  World world;  // at its start
  Timeline timeline;
  std::size_t body = 0;             // for which why_not_flat() has no reason
  Vec3 point = Vec3::Zero();        // m, body frame, on the line that the body hangs by
  std::vector<Waypoint> waypoints;  // times rising
  double until = 0;                 // s, when hand and body rest again
  HandLimits limits;
  /// A held body points away from a place so far (m) behind the connector's end; infinite: it
  /// keeps its orientation.
  double pivot = std::numeric_limits<double>::infinity();
};

// Where a hand is that leads a connector's end, and how it turns.

/// A path carries the end at a lever from its origin. The lever points away from a pivot that
/// rests, as a stick in a hand turns about the elbow; with the pivot infinitely far it keeps its
/// direction.
class HandFrame {
 public:
  /// Of the connector that the body hangs by, at the pose of its driver's last key; the pivot is
  /// `pivot` (m) behind the end.
  HandFrame(const World& world, std::size_t body, double pivot);

  /// The path's origin, from the series of the end that it leads.
  TaylorSeries origin(const TaylorSeries& end) const;
  /// The path's rotation; without spin about the lever.
  Quat rotation(const Vec3& end) const;

  /// The place that the lever points away from (m); nothing where there is none.
  std::optional<Vec3> pivot() const {
    return turns() ? std::optional<Vec3>(rest_ - pivot_ * along_) : std::nullopt;
  }
  /// Where the end is at rest (m).
  const Vec3& rest() const { return rest_; }

 private:
  bool turns() const { return lever_ > 0 && std::isfinite(pivot_); }

  Vec3 rest_, along_;  // m; of the lever at rest, a unit vector
  Quat rest_rotation_;
  double lever_ = 0, pivot_ = 0;  // m
};

/// The path that drives the connector of that body.
std::shared_ptr<const Path> hand_path(const World& world, std::size_t body);

// Curves that are sums of Gaussians at even times: analytic, so that every derivative exists, and
// each coefficient bends its own part of the curve alone.

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
