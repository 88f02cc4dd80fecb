#include "sim/measure/curves.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace taut {
namespace {

/// The signed share of all directions, of either sense, from which two segments are seen to cross.
double seen_to_cross(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ac = c - a, ad = d - a, bc = c - b, bd = d - b;
  Vec3 normals[] = {ac.cross(ad), ad.cross(bd), bd.cross(bc), bc.cross(ac)};
  for (Vec3& normal : normals) {
    const double length = normal.norm();
    if (!(length > 0)) return 0;  // in one plane
    normal /= length;
  }
  double angle = 0;
  for (int i = 0; i < 4; ++i) {
    angle += std::asin(std::clamp(normals[i].dot(normals[(i + 1) % 4]), -1.0, 1.0));
  }
  const double side = (d - c).cross(b - a).dot(ac);
  return (side > 0 ? angle : -angle) / (4 * std::numbers::pi);
}

std::size_t segments(const Curve& curve) {
  const std::size_t corners = curve.corners.size();
  return curve.closed || corners == 0 ? corners : corners - 1;
}

const Vec3& corner(const Curve& curve, std::size_t index) {
  return curve.corners[index % curve.corners.size()];
}

/// The curve, closed on a sphere of `radius` (m) about `middle`.
Curve closed_far_away(Curve curve, const Vec3& middle, double radius) {
  if (curve.closed || curve.corners.size() < 2) return curve;
  const auto outwards = [&](const Vec3& from) {
    const Vec3 way = from - middle;
    return way.norm() > 0 ? way.normalized() : Vec3(Vec3::UnitX());
  };
  const Vec3 first = outwards(curve.corners.front()), last = outwards(curve.corners.back());
  Vec3 axis = last.cross(first);
  if (!(axis.norm() > 1e-9)) axis = last.unitOrthogonal();
  axis.normalize();
  constexpr int kParts = 8;
  const double turn = std::atan2(last.cross(first).dot(axis), last.dot(first));
  for (int i = 0; i <= kParts; ++i) {
    const Vec3 at = Eigen::AngleAxisd(turn * i / kParts, axis) * last;
    curve.corners.push_back(middle + radius * at);
  }
  curve.closed = true;
  return curve;
}

}  // namespace

Curve curve_of(const World& world, std::size_t connector) {
  Curve made{world.connectors[connector].position};
  const std::size_t last = made.corners.size() - 1;
  for (const Joint& joint : world.joints) {
    const auto ties = [&](std::size_t particle) {
      return std::ranges::any_of(joint.particles, [&](const Joint::Particle& at) {
        return at.connector == connector && at.particle == particle;
      });
    };
    made.closed = made.closed || (last > 0 && ties(0) && ties(last));
  }
  if (made.closed) made.corners.pop_back();
  return made;
}

int linking_number(const Curve& one, const Curve& other) {
  Vec3 middle = Vec3::Zero();
  for (const Curve* curve : {&one, &other}) {
    for (const Vec3& at : curve->corners) middle += at;
  }
  middle /=
      static_cast<double>(std::max<std::size_t>(one.corners.size() + other.corners.size(), 1));
  double size = 0;
  for (const Curve* curve : {&one, &other}) {
    for (const Vec3& at : curve->corners) size = std::max(size, (at - middle).norm());
  }
  // Of different size, so that what closes one is apart from what closes the other.
  const Curve a = closed_far_away(one, middle, 10 * size);
  const Curve b = closed_far_away(other, middle, 20 * size);
  double sum = 0;
  for (std::size_t i = 0; i < segments(a); ++i) {
    for (std::size_t k = 0; k < segments(b); ++k) {
      sum += seen_to_cross(corner(a, i), corner(a, i + 1), corner(b, k), corner(b, k + 1));
    }
  }
  return static_cast<int>(std::lround(sum));
}

double writhe(const Curve& curve) {
  double sum = 0;
  for (std::size_t i = 0; i < segments(curve); ++i) {
    for (std::size_t k = i + 2; k < segments(curve); ++k) {
      sum += seen_to_cross(corner(curve, i), corner(curve, i + 1), corner(curve, k),
                           corner(curve, k + 1));
    }
  }
  return 2 * sum;
}

}  // namespace taut
