// Rotations: from one direction to another, and of a rigid body without torque.
#pragma once

#include <array>

#include "sim/motion/types.h"

namespace taut {

/// The smallest rotation that takes the direction of `from` to that of `to`, of any lengths but
/// zero; between opposite ones, one about any axis across. Eigen's finds that axis by a singular
/// value decomposition, which takes a quarter of a minute to compile.
Quat rotation_between(const Vec3& from, const Vec3& to);

/// The matrix whose product with a vector is the cross product of `v` with it.
inline Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// An inertia about its principal axes.
struct PrincipalAxes {
  Vec3 moments;  // kg m^2, rising
  Mat3 axes;     // one in each column
};
PrincipalAxes principal_axes(const Mat3& inertia);

/// How fast the quaternion of a rotation changes at a spin (rad/s, world axes).
inline Quat quaternion_rate(const Vec3& spin, const Quat& rotation) {
  return Quat(0, spin.x() / 2, spin.y() / 2, spin.z() / 2) * rotation;
}

/// Rotates a rigid body with no torque on it, keeping its angular momentum to rounding. Exact for a
/// symmetric top; second order in the step, without drift of the energy, for any other body.
class FreeRotation {
 public:
  /// `inertia` about the centre of mass in the body's axes, kg m^2; zero moments are allowed.
  explicit FreeRotation(const Mat3& inertia);

  /// Advances a body's rotation and its spin (rad/s, world axes) by `dt` (s).
  void turn(Quat& rotation, Vec3& spin, double dt) const;

  /// The inverse inertia in the world's axes for a body so turned; zero along moments that are
  /// zero.
  Mat3 inverse_inertia(const Quat& rotation) const;

 private:
  Quat axes_;     // principal axes in the body's: the third is the odd one out
  Vec3 moments_;  // kg m^2, about the principal axes
  Vec3 inverse_;  // 1/(kg m^2), zero where the moment is zero
};

}  // namespace taut
