// What the direct method's integrators step: second-order motion of a few coordinates.
#pragma once

#include <cstddef>

namespace taut::direct {

/// q'' = a(t, q, q'), with arrays of size() doubles. The coordinates are directions (unit vectors
/// and unit quaternions), never positions: every length holds whatever an integrator does.
class Motion {
 public:
  virtual ~Motion() = default;

  virtual std::size_t size() const = 0;
  /// Writes q'' at `time` (s).
  virtual void acceleration(double time, const double* q, const double* rate, double* out) = 0;
  /// Returns q and q' to where they belong after a step: unit lengths, closed loops.
  virtual void project(double time, double* q, double* rate) = 0;
  /// The RMS error of the particles' positions (m) that the errors `eq` of q and `er` of q' cause.
  /// An error of velocity counts for as much as it moves a particle in a short while.
  virtual double error(const double* eq, const double* er) const = 0;

  // A chart for long steps, in which the unit lengths hold of themselves: of each q its part x
  // across its place in `base`, so that q = x + sqrt(1 - x.x) base.

  /// From the chart to q, in place; false where x has left the chart.
  virtual bool lift(const double* base, double* x, double* rate) const = 0;
  /// Leaves of x what lies across `base`.
  virtual void across(const double* base, double* x) const = 0;
  /// Factors sigma_squared - L, L the stiff part of the derivative of the last acceleration by q.
  virtual void freeze(double sigma_squared) = 0;
  virtual void solve_frozen(double* x) const = 0;
};

}  // namespace taut::direct
