#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/reader/reader.h"

namespace taut::scenes {

namespace {

/// Where the straight piece from a to b, taken from the share `u` on, leaves the ball of radius
/// `r` about `centre`, as a share of the piece; above 1 when it stays inside.
double exit_share(const Vec3& a, const Vec3& b, const Vec3& centre, double r) {
  // |a + u (b - a) - centre|^2 = r^2; of the two zeros the larger is the way out.
  const Vec3 piece = b - a, from = a - centre;
  const double p = piece.dot(from), q = piece.squaredNorm();
  if (q == 0) return 2;
  return (-p + std::sqrt(std::max(0.0, p * p - q * (from.squaredNorm() - r * r)))) / q;
}

}  // namespace

std::vector<Vec3> evenly_along(const std::vector<Vec3>& corners, std::size_t particles) {
  std::vector<double> until{0};  // m, of the corners
  for (std::size_t i = 1; i < corners.size(); ++i) {
    until.push_back(until.back() + (corners[i] - corners[i - 1]).norm());
  }
  std::vector<Vec3> line;
  std::size_t piece = 0;
  for (std::size_t i = 0; i < particles; ++i) {
    const double along = until.back() * static_cast<double>(i) / static_cast<double>(particles - 1);
    while (piece + 2 < corners.size() && until[piece + 1] < along) ++piece;
    const double length = until[piece + 1] - until[piece];
    const double share = length > 0 ? std::min(1.0, (along - until[piece]) / length) : 0;
    line.push_back(corners[piece] + share * (corners[piece + 1] - corners[piece]));
  }
  return line;
}

std::vector<Vec3> along_line(const std::vector<Vec3>& corners, std::size_t particles, double link) {
  // The last link may miss its length by the rounding of the numbers in the file; one that ends at
  // a corner by the rounding of the sums, or it would end beyond it by the root of that.
  constexpr double rounding_in_file = 1e-6, rounding_of_sums = 1e-9;
  std::vector<Vec3> line{corners.front()};
  std::size_t piece = 0;
  while (line.size() < particles) {
    const Vec3 last = line.back();
    for (;; ++piece) {
      const double share = exit_share(corners[piece], corners[piece + 1], last, link);
      const bool ends = piece + 2 == corners.size();
      const double missing = (share - 1) * (corners[piece + 1] - corners[piece]).norm();
      const double rounding = ends ? rounding_in_file : rounding_of_sums;
      if (share <= 1 || (share < 2 && missing <= rounding * link)) {
        line.push_back(corners[piece] + share * (corners[piece + 1] - corners[piece]));
        break;
      }
      if (ends) return line;
    }
  }
  return line;
}

std::vector<Vec3> polygon(const Vec3& axis, const Vec3& centre, const Connector& connector,
                          const std::optional<Vec3>& first) {
  const double corners = static_cast<double>(connector.links());
  const double radius = connector.rest.front() / (2 * std::sin(std::numbers::pi / corners));
  const Vec3 towards = first ? Vec3(*first - centre) : axis.unitOrthogonal();
  const Vec3 x = (towards - axis.dot(towards) * axis).stableNormalized(), y = axis.cross(x);
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < connector.links(); ++i) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(i) / corners;
    places.push_back(centre + radius * (std::cos(turn) * x + std::sin(turn) * y));
  }
  places.push_back(places.front());
  return places;
}

}  // namespace taut::scenes
