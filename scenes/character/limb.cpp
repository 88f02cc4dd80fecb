#include "scenes/character/limb.h"

#include <algorithm>
#include <cmath>

namespace taut::scenes {
namespace {

/// The rotation that takes x to `along` and z to `normal` (perpendicular to it).
Mat3 frame(const Vec3& along, const Vec3& normal) {
  Mat3 m;
  m.col(0) = along.normalized();
  m.col(2) = (normal - normal.dot(m.col(0)) * m.col(0)).normalized();
  m.col(1) = m.col(2).cross(m.col(0));
  return m;
}

}  // namespace

LimbTurns bend_limb(const Limb& limb, const Vec3& root, const Vec3& target, const Vec3& pole) {
  const double a = limb.upper.norm(), b = limb.lower.norm();
  const Vec3 to_target = target - root;
  const Vec3 along = to_target.norm() > 1e-9 ? to_target.normalized() : Vec3(0, -1, 0);
  const double distance = std::clamp(to_target.norm(), 1.05 * std::abs(a - b), limb.reach());
  const Vec3 across = pole - pole.dot(along) * along;
  const Vec3 side = across.norm() > 1e-9 ? across.normalized() : along.unitOrthogonal();

  const double x = (a * a - b * b + distance * distance) / (2 * distance);
  const double h = std::sqrt(std::max(a * a - x * x, 0.0));
  const Vec3 middle = root + x * along + h * side;
  const Vec3 normal = along.cross(side) * -1;  // as of cross(upper, lower) of the bent limb
  Vec3 rest_normal = limb.upper.cross(limb.lower);
  constexpr double kStraight = 0.05;  // rad
  if (rest_normal.norm() < kStraight * a * b && !limb.bends.isZero())
    rest_normal = limb.upper.cross(limb.bends);
  if (rest_normal.norm() < 1e-9 * a * b) rest_normal = limb.upper.unitOrthogonal();
  const auto turn = [&](const Vec3& rest, const Vec3& now) {
    return Quat(frame(now, normal) * frame(rest, rest_normal).transpose());
  };
  return {turn(limb.upper, middle - root), turn(limb.lower, root + distance * along - middle),
          middle};
}

double twist_about(const Quat& rotation, const Vec3& axis) {
  const double angle = 2 * std::atan2(rotation.vec().dot(axis), rotation.w());
  return std::remainder(angle, 2 * M_PI);
}

}  // namespace taut::scenes
