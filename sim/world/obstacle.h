// Obstacles, which connectors touch: a shape in the world, fixed or on a path.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "sim/motion/path.h"
#include "sim/motion/types.h"
#include "sim/world/shape.h"

namespace taut {

/// A solid that nothing moves but its path. Beads of connectors and capsules of free bodies
/// never enter it.
struct Obstacle {
  std::string name;
  Shape shape;
  Pose place;                        // of the shape's frame: in the world, or in the path's frame
  std::shared_ptr<const Path> path;  // null: it stands still
  double static_friction = 0, kinetic_friction = 0;  // Coulomb's coefficients
  double restitution = 0;                            // Newton's coefficient, 0 to 1
  std::uint64_t ignores = 0;  // what has one of these categories passes through it

  bool touches(std::uint64_t category) const { return (ignores & category) == 0; }
  /// The motion of the shape's frame at `time` (s).
  FrameMotion frame(double time) const;
};

/// A unit vector (world axes) out of the obstacle, and how far (m) a ball of `radius` (m) at
/// `point` is from touching it; negative where it is inside.
SurfaceDistance gap(const Obstacle& obstacle, const Pose& frame, const Vec3& point, double radius);

/// A hash of all of an obstacle that does not change.
std::uint64_t fingerprint(const Obstacle& obstacle);

}  // namespace taut
