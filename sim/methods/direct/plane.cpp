#include "sim/methods/direct/plane.h"

#include <algorithm>

namespace taut::direct {
namespace {

/// The one of `vectors`, as unit vectors, that leaves `line` most; zero where none does.
Vec3 farthest_from(const Vec3& line, const std::vector<Vec3>& vectors) {
  constexpr double kNone = 1e-9;  // of a unit vector: less is rounding
  Vec3 best = Vec3::Zero();
  double most = kNone;
  for (const Vec3& v : vectors) {
    if (!(v.norm() > 0)) continue;
    const Vec3 unit = v.normalized();
    const Vec3 off = unit - unit.dot(line) * line;
    if (off.norm() > most) {
      most = off.norm();
      best = off.normalized();
    }
  }
  return best;
}

}  // namespace

std::optional<Plane> common_plane(const std::vector<Vec3>& vectors,
                                  const std::vector<Vec3>& hints) {
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

}  // namespace taut::direct
