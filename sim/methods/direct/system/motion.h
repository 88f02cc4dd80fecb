// The motion that the direct method's integrators step: a few coordinates, of second order.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>

#include "sim/methods/direct/system/vector.h"
#include "sim/world/world.h"

namespace taut::direct {

/// The estimated error (m) of a step.
struct StepError {
  double all = 0;          // in places and velocities
  double followed = 0;     // of that, less the damped part of waves passed over
  double passed_over = 0;  // in places, on those waves
};

/// q'' = a(t, q, q'), with arrays of size() doubles, a multiple of four; padding among them is
/// zero. The coordinates are directions (angles, unit vectors and unit quaternions), never
/// positions: every length holds whatever an integrator does.
class Motion {
 public:
  virtual ~Motion() = default;

  /// Reads the state from the world, whose time is `time`.
  virtual void load(const World& world, double time, double* q, double* rate) = 0;
  /// Writes the state at the world's time, positions included, to the world, in which what is
  /// prescribed is at its place.
  virtual void store(World& world, const double* q, const double* rate) = 0;
  /// Reads holds from `world` from now on.
  virtual void attach(const World& world) = 0;
  /// The acceleration by which a hold has left the plane since load(), if one has.
  virtual const std::optional<Vec3>& left_plane() const = 0;
  virtual double length() const = 0;    // m, of all links
  virtual double shortest() const = 0;  // m, of a link
  /// An upper bound of the frequencies (rad/s) of the waves under the last tensions.
  virtual double wave_frequency() const = 0;

  virtual std::size_t size() const = 0;
  /// Writes q'' at `time` (s).
  virtual void acceleration(double time, const double* q, const double* rate, double* out) = 0;
  /// Returns q and q' to where they belong after a step: unit lengths, closed loops. False where
  /// that leaves a loop open.
  virtual bool project(double time, double* q, double* rate) = 0;
  /// The cost of project(), in accelerations.
  virtual double projection_cost() const = 0;
  /// The cycles (see Counters::cycles) of an acceleration and of the integrator's use of it.
  virtual double cycles() const = 0;
  /// By how far (m, RMS) a small change of q displaces the particles.
  virtual double displacement(const double* change) const = 0;
  /// A cheap upper bound of that, from the sum of the squares of `change`.
  virtual double displacement_bound(double squares) const = 0;
  /// The time (s) for which an error of velocity counts.
  virtual double velocity_time() const = 0;
  /// The error (m) of the particles' positions that the errors of q and q' amount to.
  double error(const double* of_q, const double* of_rate) const {
    const double place = displacement(of_q), speed = velocity_time() * displacement(of_rate);
    return std::sqrt(place * place + speed * speed);
  }

  // A chart for long steps, in which the unit lengths hold of themselves: of each q its part x
  // across its place in `base`, so that q = x + sqrt(1 - x.x) base.

  /// From the chart to q, in place; false where x has left the chart.
  virtual bool retract(const double* base, double* x, double* rate) const = 0;
  /// Leaves of x what lies across `base`.
  virtual void to_tangent(const double* base, double* x) const = 0;
  /// Factors sigma_squared - L, L the stiff part of the derivative of the last acceleration by q.
  virtual void factor(double sigma_squared) = 0;
  virtual void solve_factored(double* x) const = 0;
};

/// A particle without mass, which the model has no equation for, is taken to weigh this share of
/// everything that moves with it.
inline constexpr double kLeastMassShare = 1e-9;

/// An error of velocity counts for this time (s): a share of that in which a pendulum of `length`
/// (m) would turn it into an error of position.
inline double velocity_time_of(double length) {
  constexpr double kShare = 0.15;
  constexpr double kStandardGravity = 9.80665;  // m/s^2
  return kShare * std::sqrt(length / kStandardGravity);
}

}  // namespace taut::direct
