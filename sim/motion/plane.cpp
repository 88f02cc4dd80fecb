#include "sim/motion/plane.h"

#include <algorithm>

namespace taut {
namespace {

/// The one of `vectors`, as unit vectors, that leaves `line` most; zero where none does.
Vec3 farthest_from(const Vec3& line, std::span<const Vec3> vectors) {
  constexpr double kNone = 1e-9;  // of a unit vector: less is rounding
  const auto off = [&](const Vec3& v) -> Vec3 { return v - v.dot(line) * line; };
  const Vec3* best = nullptr;
  double most = kNone * kNone;
  for (const Vec3& v : vectors) {
    const double square = off(v).squaredNorm(), all = v.squaredNorm();
    if (!(square > most * all)) continue;
    most = square / all;
    best = &v;
  }
  return best ? off(best->normalized()).normalized() : Vec3(0, 0, 0);
}

}  // namespace

std::optional<Plane> common_plane(std::span<const Vec3> vectors, std::span<const Vec3> hints) {
  const auto first = std::ranges::find_if(vectors, [](const Vec3& v) { return v.norm() > 0; });
  if (first == vectors.end()) return std::nullopt;
  Plane plane;
  plane.x = first->normalized();
  plane.y = farthest_from(plane.x, vectors);
  if (plane.y.isZero()) plane.y = farthest_from(plane.x, hints);
  if (plane.y.isZero()) plane.y = plane.x.unitOrthogonal();
  plane.normal = plane.x.cross(plane.y);
  const bool all = std::ranges::all_of(vectors, [&](const Vec3& v) { return plane.holds(v); });
  return all ? std::optional(plane) : std::nullopt;
}

}  // namespace taut
