// What the direct method's integrators step: second-order motion of a few coordinates.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>

#include "sim/methods/direct/vector.h"
#include "sim/world.h"

namespace taut::direct {

/// q'' = a(t, q, q'), with arrays of size() doubles, a multiple of four; what is no coordinate
/// among them is zero. The coordinates are directions (angles, unit vectors and unit quaternions),
/// never positions: every length holds whatever an integrator does.
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
  virtual double fastest() const = 0;

  virtual std::size_t size() const = 0;
  /// Writes q'' at `time` (s).
  virtual void acceleration(double time, const double* q, const double* rate, double* out) = 0;
  /// Returns q and q' to where they belong after a step: unit lengths, closed loops.
  virtual void project(double time, double* q, double* rate) = 0;
  /// What that costs, in accelerations.
  virtual double projection_cost() const = 0;
  /// The cycles (see Counters::work) of an acceleration, and of what an integrator makes of it.
  virtual double work() const = 0;
  /// By how far (m, RMS) a small change of q displaces the particles.
  virtual double shift(const double* change) const = 0;
  /// A cheap upper bound of that, from the sum of the squares of `change`.
  virtual double shift_bound(double squares) const = 0;
  struct Energy {
    double kinetic = 0, potential = 0;  // J
    double mass = 0;                    // kg, of all that moves
    double sum() const { return kinetic + potential; }
  };
  /// That of a state at `time`, where no end is driven.
  virtual Energy energy(double time, const double* q, const double* rate) = 0;
  virtual double gravity() const = 0;  // m/s^2
  /// The time (s) for which an error of velocity counts.
  virtual double memory() const = 0;
  /// The error (m) of the particles' positions that the errors of q and q' amount to.
  double error(const double* of_q, const double* of_rate) const {
    const double place = shift(of_q), speed = memory() * shift(of_rate);
    return std::sqrt(place * place + speed * speed);
  }

  /// Whether there is leap().
  virtual bool leaps() const { return false; }
  /// The bound of fastest() if it hung from its hold.
  virtual double fastest_hanging() const { return 0; }
  /// Whether, by the last tensions, links push and none pulls.
  virtual bool pushes() const { return false; }
  /// From q at `time` (s), to which a step of `last` (s) from q_before led, writes where a step of
  /// h leads on, by the second differences of places under the last tensions and what lengths take
  /// to hold; into `turned` by how much those turned the directions. Returns the most (of a length)
  /// that a link was off without.
  virtual double leap(double, double, double, const double*, const double*, double*, double*) {
    return 0;
  }

  // A chart for long steps, in which the unit lengths hold of themselves: of each q its part x
  // across its place in `base`, so that q = x + sqrt(1 - x.x) base.

  /// From the chart to q, in place; false where x has left the chart.
  virtual bool lift(const double* base, double* x, double* rate) const = 0;
  /// Leaves of x what lies across `base`.
  virtual void across(const double* base, double* x) const = 0;
  /// Factors sigma_squared - L, L the stiff part of the derivative of the last acceleration by q.
  virtual void freeze(double sigma_squared) = 0;
  virtual void solve_frozen(double* x) const = 0;
  /// For two right sides, of which the second lies behind the first.
  virtual void solve_frozen(double* x, double* y) const {
    solve_frozen(x);
    solve_frozen(y);
  }
};

}  // namespace taut::direct
