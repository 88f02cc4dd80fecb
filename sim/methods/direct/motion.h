// What the direct method's integrators step: second-order motion of a few coordinates.
#pragma once

#include <cstddef>

namespace taut::direct {

/// q'' = a(t, q, q'), with arrays of size() doubles. The coordinates are directions (unit vectors,
/// unit quaternions, angles), never positions: every length holds whatever the integrator does.
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
  virtual double error(const double* q, const double* eq, const double* er) const = 0;
};

}  // namespace taut::direct
