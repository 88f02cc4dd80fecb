#include "sim/world/obstacle.h"

#include "sim/motion/hash.h"

namespace taut {

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
