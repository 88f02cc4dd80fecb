#include "sim/world/obstacle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/motion/hash.h"

namespace taut {
namespace {

/// From a point to the origin, less `radius`; `across` where the point is the origin.
SurfaceDistance from_centre(const Vec3& offset, double radius, const Vec3& across) {
  const double far = offset.norm();
  return {far - radius, far > 0 ? Vec3(offset / far) : across};
}

/// Of a box that reaches `half` from the origin before its edges are rounded, by the offsets beyond
/// it along each axis, negative inside.
template <int N>
double beyond(const Eigen::Matrix<double, N, 1>& over, Eigen::Matrix<double, N, 1>& direction) {
  const Eigen::Matrix<double, N, 1> out = over.cwiseMax(0.0);
  const double far = out.norm();
  if (far > 0) {
    direction = out / far;
    return far;
  }
  int nearest = 0;
  const double depth = over.maxCoeff(&nearest);
  direction.setZero();
  direction[nearest] = 1;
  return depth;
}

SurfaceDistance from_box(const Vec3& half, double rounding, const Vec3& point) {
  Vec3 normal;
  const double far = beyond<3>(point.cwiseAbs() - half, normal);
  for (int i = 0; i < 3; ++i) normal[i] = std::copysign(normal[i], point[i]);
  return {far - rounding, normal};
}

SurfaceDistance from_cylinder(const Shape& shape, const Vec3& point) {
  const double from_axis = std::sqrt(point.x() * point.x() + point.z() * point.z());
  const Vec3 out =
      from_axis > 0 ? Vec3(point.x() / from_axis, 0, point.z() / from_axis) : Vec3(Vec3::UnitX());
  Eigen::Vector2d direction;
  const Eigen::Vector2d over(from_axis - (shape.radius - shape.rounding),
                             std::abs(point.y()) - (shape.length / 2 - shape.rounding));
  const double far = beyond<2>(over, direction);
  const double up = std::copysign(direction[1], point.y());
  return {far - shape.rounding, direction[0] * out + up * Vec3::UnitY()};
}

/// The change of a unit vector per second, of which `far` times the vector changes by `rate`.
template <int N>
Eigen::Matrix<double, N, 1> direction_rate(const Eigen::Matrix<double, N, 1>& direction, double far,
                                           const Eigen::Matrix<double, N, 1>& rate) {
  if (!(far > 0)) return Eigen::Matrix<double, N, 1>::Zero();
  return (rate - direction.dot(rate) * direction) / far;
}

/// The change of the direction that beyond() finds, of offsets that change by `rate`.
template <int N>
Eigen::Matrix<double, N, 1> beyond_rate(const Eigen::Matrix<double, N, 1>& over,
                                        Eigen::Matrix<double, N, 1> rate) {
  Eigen::Matrix<double, N, 1> direction;
  const double far = beyond<N>(over, direction);
  for (int i = 0; i < N; ++i) {
    if (over[i] < 0 || (over[i] == 0 && rate[i] < 0)) rate[i] = 0;
  }
  return direction_rate<N>(direction, far, rate);
}

Vec3 box_normal_rate(const Vec3& half, const Vec3& point, const Vec3& velocity) {
  Vec3 side;
  for (int i = 0; i < 3; ++i) side[i] = std::copysign(1.0, point[i]);
  const Vec3 rate = beyond_rate<3>(point.cwiseAbs() - half, side.cwiseProduct(velocity));
  return side.cwiseProduct(rate);
}

Vec3 cylinder_normal_rate(const Shape& shape, const Vec3& point, const Vec3& velocity) {
  const Vec3 across(point.x(), 0, point.z());
  const double from_axis = across.norm(), side = std::copysign(1.0, point.y());
  const Vec3 out = from_axis > 0 ? Vec3(across / from_axis) : Vec3(Vec3::UnitX());
  const Eigen::Vector2d over(from_axis - (shape.radius - shape.rounding),
                             std::abs(point.y()) - (shape.length / 2 - shape.rounding));
  Eigen::Vector2d direction;
  beyond<2>(over, direction);
  const Eigen::Vector2d turn =
      beyond_rate<2>(over, Eigen::Vector2d(out.dot(velocity), side * velocity.y()));
  const Vec3 around = direction_rate<3>(out, from_axis, Vec3(velocity.x(), 0, velocity.z()));
  return turn[0] * out + direction[0] * around + side * turn[1] * Vec3::UnitY();
}

}  // namespace

SurfaceDistance Shape::from(const Vec3& point) const {
  switch (kind) {
    case Kind::plane:
      break;
    case Kind::sphere:
      return from_centre(point, radius, Vec3::UnitX());
    case Kind::capsule: {
      const double along = std::clamp(point.y(), -length / 2, length / 2);
      return from_centre(point - along * Vec3::UnitY(), radius, Vec3::UnitX());
    }
    case Kind::cylinder:
      return from_cylinder(*this, point);
    case Kind::box:
      return from_box(size / 2 - Vec3::Constant(rounding), rounding, point);
  }
  return {point.y(), Vec3::UnitY()};
}

Vec3 Shape::normal_rate(const Vec3& point, const Vec3& velocity) const {
  switch (kind) {
    case Kind::plane:
      break;
    case Kind::sphere:
      return direction_rate<3>(point.normalized(), point.norm(), velocity);
    case Kind::capsule: {
      const double over = std::abs(point.y()) - length / 2;
      const bool on_cap = over > 0 || (over == 0 && point.y() * velocity.y() > 0);
      const Vec3 offset = point - std::clamp(point.y(), -length / 2, length / 2) * Vec3::UnitY();
      const Vec3 rate = on_cap ? velocity : Vec3(velocity.x(), 0, velocity.z());
      return direction_rate<3>(offset.normalized(), offset.norm(), rate);
    }
    case Kind::cylinder:
      return cylinder_normal_rate(*this, point, velocity);
    case Kind::box:
      return box_normal_rate(size / 2 - Vec3::Constant(rounding), point, velocity);
  }
  return Vec3::Zero();
}

double Shape::sharpest() const {
  if (kind == Kind::plane) return std::numeric_limits<double>::infinity();
  return kind == Kind::sphere || kind == Kind::capsule ? radius : rounding;
}

Shape plane_shape() {
  return {};
}

Shape sphere_shape(double radius) {
  return {.kind = Shape::Kind::sphere, .radius = radius};
}

Shape capsule_shape(double radius, double length) {
  return {.kind = Shape::Kind::capsule, .radius = radius, .length = length};
}

Shape cylinder_shape(double radius, double length, double rounding) {
  return {.kind = Shape::Kind::cylinder, .radius = radius, .length = length, .rounding = rounding};
}

Shape box_shape(const Vec3& size, double rounding) {
  return {.kind = Shape::Kind::box, .size = size, .rounding = rounding};
}

FrameMotion Obstacle::frame(double time) const {
  FrameMotion motion;
  motion.position = place.position;
  motion.rotation = place.rotation;
  if (!path) return motion;
  const FrameMotion carrier = path->at(time);
  const PointMotion origin = carrier.point(place.position);
  motion = carrier;
  motion.position = origin.position;
  motion.velocity = origin.velocity;
  motion.acceleration = origin.acceleration;
  motion.rotation = carrier.rotation * place.rotation;
  return motion;
}

SurfaceDistance gap(const Obstacle& obstacle, const Pose& frame, const Vec3& point, double radius) {
  if (obstacle.shape.kind == Shape::Kind::plane) {
    const Vec3 normal = frame.rotation * Vec3::UnitY();
    return {normal.dot(point - frame.position) - radius, normal};
  }
  SurfaceDistance found =
      obstacle.shape.from(frame.rotation.conjugate() * Vec3(point - frame.position));
  found.distance -= radius;
  found.normal = frame.rotation * found.normal;
  return found;
}

std::uint64_t fingerprint(const Obstacle& obstacle) {
  Hash hash;
  const Shape& shape = obstacle.shape;
  hash.word(static_cast<std::uint64_t>(shape.kind)).word(shape.radius).word(shape.length);
  for (const double c : shape.size) hash.word(c);
  hash.word(shape.rounding);
  for (const double c : obstacle.place.position) hash.word(c);
  for (const double c : obstacle.place.rotation.coeffs()) hash.word(c);
  hash.word(obstacle.path ? obstacle.path->fingerprint() : 0);
  hash.word(obstacle.static_friction).word(obstacle.kinetic_friction).word(obstacle.restitution);
  if (obstacle.ignores != 0) hash.word(obstacle.ignores);
  return hash.value();
}

}  // namespace taut
