#include "scenes/character/touch.h"

#include <algorithm>
#include <cmath>

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
    // As distance() has it, but for the root, which the nearest point alone needs.
    const Vec3 axis = c.b - c.a;
    const double length = axis.squaredNorm();
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& p : bent.part(part)) {
      const Vec3 from = p - c.a;
      const double t = std::clamp(from.dot(axis) / length, 0.0, 1.0);
      nearest = std::min(nearest, (from - t * axis).squaredNorm());
    }
    most = std::min(most, std::sqrt(nearest) - c.radius);
  }
  return most;
}

}  // namespace taut::scenes
