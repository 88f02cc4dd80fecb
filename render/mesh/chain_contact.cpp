#include "render/mesh/chain_contact.h"

#include <algorithm>
#include <cmath>

namespace taut::mesh {
namespace {

constexpr int kRounds = 40;

/// A point as a bar sees it: out from the rim's rounding (x) and up from it (y), and the direction
/// out of the axis.
struct Seen {
  double x, y;
  Vec3 out;
};

Seen seen(const BarEnd& bar, const Vec3& point) {
  const Vec3 r = point - bar.top;
  const double up = r.dot(bar.axis);
  const Vec3 out = r - up * bar.axis;
  const double radius = out.norm();
  return {radius - (bar.radius - bar.rounding), up + bar.rounding,
          radius > 1e-9 ? Vec3(out / radius) : bar.axis.unitOrthogonal()};
}

void push_out(const BarEnd& bar, Vec3& point) {
  const double depth = -distance(bar, point);
  if (depth <= 0) return;
  const auto [x, y, out] = seen(bar, point);
  if (x > 0 && y > 0) {
    point += depth * (x * out + y * bar.axis).normalized();
  } else {
    point += depth * (x > y ? out : bar.axis);
  }
}

}  // namespace

double distance(const BarEnd& bar, const Vec3& point) {
  const auto [x, y, out] = seen(bar, point);
  return std::min(std::max(x, y), 0.0) + std::hypot(std::max(x, 0.0), std::max(y, 0.0)) -
         bar.rounding;
}

std::vector<Vec3> clear_of(std::span<const BarEnd> bars, std::span<const Vec3> points) {
  std::vector<Vec3> moved(points.begin(), points.end());
  const std::size_t last = points.size() - 1;
  bool inside = false;
  for (std::size_t i = 1; i < last; ++i)
    for (const BarEnd& bar : bars) inside = inside || distance(bar, points[i]) < 0;
  for (int round = 0; inside && round < kRounds; ++round) {
    for (std::size_t i = 0; i < last; ++i) {
      const Vec3 link = moved[i + 1] - moved[i];
      const double length = (points[i + 1] - points[i]).norm(), now = link.norm();
      if (now < 1e-12) continue;
      const Vec3 miss = (1 - length / now) * link;
      const double first = i == 0 ? 0 : 1, second = i + 1 == last ? 0 : 1;
      if (first + second == 0) continue;
      moved[i] += first / (first + second) * miss;
      moved[i + 1] -= second / (first + second) * miss;
    }
    for (std::size_t i = 1; i < last; ++i)
      for (const BarEnd& bar : bars) push_out(bar, moved[i]);
  }
  return moved;
}

}  // namespace taut::mesh
