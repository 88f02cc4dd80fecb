// Vectors, rotations and the motions of points and frames. SI units, right-handed, y up.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace taut {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

/// A point at one instant: position m, velocity m/s, acceleration m/s^2, all in the world's axes.
struct PointMotion {
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  Vec3 acceleration = Vec3::Zero();
};

/// A rigid frame's place: `rotation` takes the frame's axes to the world's.
struct Pose {
  Vec3 position = Vec3::Zero();
  Quat rotation = Quat::Identity();

  Vec3 to_world(const Vec3& local) const { return position + rotation * local; }
};

/// A rigid frame at one instant: its origin's motion, its rotation, its spin (rad/s) and the spin's
/// rate (rad/s^2), both in the world's axes.
struct FrameMotion {
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  Vec3 acceleration = Vec3::Zero();
  Quat rotation = Quat::Identity();
  Vec3 spin = Vec3::Zero();
  Vec3 spin_rate = Vec3::Zero();

  Pose pose() const { return {position, rotation}; }

  /// Motion of a point fixed in the frame, given in the frame's axes (m from its origin).
  PointMotion point(const Vec3& local) const {
    if (local.isZero(0)) return {position, velocity, acceleration};
    const Vec3 r = rotation * local;
    return {position + r, velocity + spin.cross(r),
            acceleration + spin_rate.cross(r) + spin.cross(spin.cross(r))};
  }
};

// The larger of two numbers where one may be nan.

/// The larger of two numbers, and nan where one is: std::max() may hide it.
inline double larger(double a, double b) {
  return b > a || b != b ? b : a;
}

}  // namespace taut
