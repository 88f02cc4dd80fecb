// The way along which a span pulls, around what its connector presses on.
#pragma once

#include <vector>

#include "sim/methods/bead_touches.h"
#include "sim/topology/span.h"

namespace taut::methods {

/// A span between two ends that its beads' touches bend: straight from the one end to the first
/// corner, from corner to corner, and from the last to the other end. As nothing between the ends
/// of the paper has mass, the pull is the same along all of it but for friction, by which it grows
/// at each corner in the direction of sliding, to (1 + mu tan a)/(1 - mu tan a) of what it was, a
/// half the angle of the bend: Coulomb's law where the pulls press on the surface.
struct SpanPath {
  struct Corner {
    std::size_t particle = 0;
    Vec3 at = Vec3::Zero();  // m
    /// m/s, of the surface there, and of it what moves the corner while the connector slides.
    Vec3 carried = Vec3::Zero(), led = Vec3::Zero();
  };
  enum class State {
    slack,  // nothing pulls
    held,   // friction holds it: both parts are spans by themselves, as at a pin
    slides_to_a,
    slides_to_b,
  };

  bool bends = false;
  Corner first, last;
  double inner = 0, inner_rate = 0;          // m and m/s, of the way from the first to the last
  double most_stuck = 1, most_slid = 1;      // of the pull at one end over that at the other
  double first_length = 0, last_length = 0;  // m, of the connector beyond these corners
  State state = State::slack;
};

/// Finds paths, in a workspace of its own.
class PathFinder {
 public:
  void reserve(std::size_t particles) { corners_.reserve(particles); }
  /// The path of a span, with the particles at their places.
  SpanPath find(const World& world, const Span& span, const std::vector<double>& along,
                BeadTouches& touches);
  /// The beads at its corners.
  const std::vector<TouchingBead*>& corners() const { return corners_; }

 private:
  std::vector<TouchingBead*> corners_;
};

}  // namespace taut::methods
