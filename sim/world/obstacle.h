// Convex shapes as signed distances, and obstacles: a shape in the world, fixed or on a path.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "sim/motion/path.h"
#include "sim/motion/types.h"

namespace taut {

// Convex shapes as signed distances.

/// A surface's distance (m, negative inside) from a point, and the unit vector along which it rises
/// fastest.
struct SurfaceDistance {
  double distance = 0;
  Vec3 normal = Vec3::UnitY();
};

/// A convex solid in a frame of its own. All are centred on the frame's origin but for the plane,
/// which fills the half space below y = 0.
struct Shape {
  enum class Kind { plane, sphere, capsule, cylinder, box };
  Kind kind = Kind::plane;
  double radius = 0;         // m: of the sphere, the capsule or the cylinder
  double length = 0;         // m, along y: of the cylinder, and of the capsule without its caps
  Vec3 size = Vec3::Zero();  // m, of the box along x, y and z
  /// m, of the edges of a cylinder or a box, which stay within their sizes; at most half of them.
  double rounding = 0;

  /// From a point in the shape's frame. Inside of a box or a cylinder the nearest face counts; on
  /// the axis of a round shape, where all directions are equal, one across it.
  SurfaceDistance from(const Vec3& point) const;

  /// The change of that normal per second (1/s), from a point that moves by `velocity` (m/s). Where
  /// surfaces of two curvatures meet, that of the one ahead counts.
  Vec3 normal_rate(const Vec3& point, const Vec3& velocity) const;

  /// The radius (m) of the sharpest curve that a rope can be bent around; infinite for a plane,
  /// zero for an edge that is not rounded.
  double sharpest() const;
};

Shape plane_shape();
Shape sphere_shape(double radius);
Shape capsule_shape(double radius, double length);
Shape cylinder_shape(double radius, double length, double rounding = 0);
Shape box_shape(const Vec3& size, double rounding = 0);

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
