// Conditions on a system that are no links of it.
#pragma once

#include <span>

#include "sim/methods/direct/system/links.h"

namespace taut::direct {

/// A condition g(x, t) = 0 on the places x of a few particles of one component, g in metres. One
/// multiplier keeps it: a force on each of those particles, along the gradient of g by its place. A
/// kind of row is a class of its own; systems know nothing else of it.
///
/// Rows join and leave at any instant (Integrator::set_rows()). A joining row's violation by
/// velocities is removed by one impulse along its gradient, as in an inelastic impact; its
/// violation by places is mended as the mass matrix weighs it. Rows that contradict each other or
/// the links end in steps that become too small.
class ConstraintRow {
 public:
  struct Particle {
    std::size_t connector = 0, index = 0;
  };
  struct Value {
    double gap = 0;            // m: g
    double rate = 0;           // m/s: g'
    double velocity_term = 0;  // m/s^2: g'' where no particle accelerates
  };
  virtual ~ConstraintRow() = default;

  /// Each free or held by a point whose motion is known.
  virtual std::span<const Particle> particles() const = 0;
  /// Writes the gradient by the place of each of those particles, which are at `points` at `time`.
  virtual Value evaluate(double time, std::span<const Point> points,
                         std::span<Vec3> gradient) const = 0;
};

}  // namespace taut::direct
