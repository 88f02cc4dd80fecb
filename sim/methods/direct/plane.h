// Worlds that move in one vertical plane, and the models that this spares.
#pragma once

#include <optional>
#include <span>

#include "sim/types.h"

namespace taut::direct {

/// Two unit vectors along a plane and the normal n = x cross y.
struct Plane {
  Vec3 x, y, normal;

  /// Whether `v` leaves the plane by more than rounding.
  bool holds(const Vec3& v) const { return std::abs(v.dot(normal)) <= 1e-11 * v.norm(); }
};

/// The plane of `vectors` (any lengths, zeros ignored), or none. Where they all lie along one line,
/// the plane contains `hints` as far as one of them leaves the line.
std::optional<Plane> common_plane(std::span<const Vec3> vectors, std::span<const Vec3> hints);

/// A rigid body in plane motion that hangs from one of its points, as two point masses on a rigid
/// line: `tip` at that point and `far` at `reach` from it, on the line through the centre of mass.
/// Mass, centre and inertia are the same, so the motion is exactly the same: the body is one more
/// link. I + M a^2 = M a s, with a the arm of the centre of mass, s the reach.
struct Stick {
  double tip = 0, far = 0;  // kg
  double reach = 0;         // m
  Stick(double mass, double inertia, double arm)
      : far(mass * arm / ((inertia + mass * arm * arm) / (mass * arm))),
        reach((inertia + mass * arm * arm) / (mass * arm)) {
    tip = mass - far;
  }
};

}  // namespace taut::direct
