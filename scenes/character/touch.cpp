#include "scenes/character/touch.h"

#include <algorithm>

#include "scenes/character/soft.h"

namespace taut::scenes {

double touch(double gap) {
  const double off = (gap - skin_gap) / mm;
  return off > 0 ? squared(off) : 25 * squared(off);
}

double distance(const Vec3& p, const Capsule& c) {
  const Vec3 axis = c.b - c.a, from = p - c.a;
  const double t = std::clamp(from.dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (from - t * axis).norm() - c.radius;
}

double gap(const BentSkin& bent, std::size_t part, std::span<const Capsule> things, double most) {
  const BentSkin::Ball& around = bent.balls[part];
  for (const Capsule& c : things) {
    if (distance(around.centre, c) - around.radius >= most) continue;
    for (const Vec3& p : bent.part(part)) most = std::min(most, distance(p, c));
  }
  return most;
}

}  // namespace taut::scenes
