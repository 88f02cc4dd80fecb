#include "sim/motion/rotation.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace taut {
namespace {

/// The rotation by the vector `angle` (rad).
Quat rotation_by(const Vec3& angle) {
  const double size = angle.norm();
  if (size == 0) return Quat::Identity();
  return Quat(Eigen::AngleAxisd(size, angle / size));
}

constexpr double kOpposite = 1e-12;
constexpr double kNoMoment = 1e-12;  // of the largest moment: a body that has none about the axis

}  // namespace

Quat rotation_between(const Vec3& from, const Vec3& to) {
  const Vec3 a = from.normalized(), b = to.normalized();
  double both = 1 + b.dot(a);                         // twice the squared cosine of half the angle
  if (both < 1e-3) both = (a + b).squaredNorm() / 2;  // the same, without cancellation
  if (both < kOpposite) {  // where the axis is lost in roundings: half a turn, and the rest
    const bool is_upright = std::abs(a.z()) > std::abs(a.x()) + std::abs(a.y());
    const Vec3 beside = is_upright ? Vec3::UnitX() : Vec3::UnitZ();
    const Vec3 axis = (beside - beside.dot(a) * a).normalized();
    return rotation_between(-a, b) * Quat(0, axis.x(), axis.y(), axis.z());
  }
  const double twice = std::sqrt(2 * both);
  Quat turn;
  turn.vec() = a.cross(b) * (1 / twice);
  turn.w() = twice / 2;
  return turn;
}

PrincipalAxes principal_axes(const Mat3& inertia) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

FreeRotation::FreeRotation(const Mat3& inertia) {
  const auto [m, principal] = principal_axes(inertia);
  const int odd = m[1] - m[0] <= m[2] - m[1] ? 2 : 0;
  const int a = odd == 2 ? 0 : 1;
  Mat3 columns;
  columns.col(0) = principal.col(a);
  columns.col(1) = principal.col(a + 1);
  columns.col(2) = columns.col(0).cross(columns.col(1));
  axes_ = Quat(columns);
  moments_ = Vec3(m[a], m[a + 1], m[odd]);
  const double least = kNoMoment * m[2];
  for (int i = 0; i < 3; ++i) {
    if (!(moments_[i] > least)) moments_[i] = 0;
    inverse_[i] = moments_[i] > 0 ? 1 / moments_[i] : 0;
  }
}

// The kinetic energy L.L/2a + (1/c - 1/a) L3^2/2 + (1/b - 1/a) L2^2/2, with a, b, c the principal
// moments, is a sum of three whose motions are rotations: about the angular momentum L, which is
// constant, and about the third and the second principal axis. The first commutes with the others;
// those are composed symmetrically (Strang), and vanish for a ball or, the last, for a symmetric
// top.
void FreeRotation::turn(Quat& rotation, Vec3& spin, double dt) const {
  const double a = moments_[0], b = moments_[1], c = moments_[2];
  if (a == 0) {  // a point, or all mass on the first axis
    rotation = (rotation_by(spin * dt) * rotation).normalized();
    return;
  }
  Quat frame = rotation * axes_;
  Vec3 own = frame.conjugate() * spin;  // in principal axes
  const Vec3 momentum = frame * own.cwiseProduct(moments_);
  const auto about_second = [&](double time) {
    if (a == b || c == 0) return;
    const Quat turned(Eigen::AngleAxisd(own.y() * (1 - b / a) * time, Vec3::UnitY()));
    frame = frame * turned;
    own = (turned.conjugate() * own.cwiseProduct(moments_)).cwiseProduct(inverse_);
  };
  about_second(dt / 2);
  const double third = own.z();  // kept by the turn about the third axis, whatever c is
  frame = frame * Quat(Eigen::AngleAxisd(third * (1 - c / a) * dt, Vec3::UnitZ()));
  own = (frame.conjugate() * momentum).cwiseProduct(inverse_);
  about_second(dt / 2);
  frame = rotation_by(momentum * (dt / a)) * frame;
  own = (frame.conjugate() * momentum).cwiseProduct(inverse_);
  if (c == 0) own.z() = third;
  rotation = (frame * axes_.conjugate()).normalized();
  spin = frame * own;
}

Mat3 FreeRotation::inverse_inertia(const Quat& rotation) const {
  const Mat3 frame = (rotation * axes_).toRotationMatrix();
  return frame * inverse_.asDiagonal() * frame.transpose();
}

}  // namespace taut
