#include "render/mesh/link_frames.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/rotation.h"

namespace taut::mesh {
namespace {

/// Links, the deviation of the smoothing. At 2 the nunchaku's links turn about themselves no faster
/// than they swing; above, neighbours in a fold stand ever less at right angles.
constexpr double kSmooth = 2;

/// A point at `share` (0 to 1) of the connector's length, linearly between particles.
Vec3 along(std::span<const Vec3> particles, double share) {
  const double at = std::clamp(share, 0.0, 1.0) * double(particles.size() - 1);
  const std::size_t i = std::min(std::size_t(at), particles.size() - 2);
  const double u = at - double(i);
  return (1 - u) * particles[i] + u * particles[i + 1];
}

Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length = v.norm();
  return length > 1e-9 ? Vec3(v / length) : otherwise;
}

}  // namespace

Vec3 transport(const Vec3& v, const Vec3& from, const Vec3& to) {
  const Vec3 turned = rotation_between(from, to) * v;
  return (turned - turned.dot(to) * to).normalized();
}

std::vector<LinkFrame> link_frames(std::span<const Vec3> particles, std::size_t links,
                                   const std::optional<ChainHold>& first,
                                   const std::optional<ChainHold>& last) {
  std::vector<LinkFrame> frames(links);
  std::vector<Vec3> directions;  // of the links, and of what holds the ends
  if (first) directions.push_back(first->axis);
  const std::size_t offset = directions.size();
  for (std::size_t i = 0; i < links; ++i) {
    LinkFrame& link = frames[i];
    link.from = along(particles, double(i) / double(links));
    link.to = along(particles, double(i + 1) / double(links));
    link.axis =
        unit_or(link.to - link.from, directions.empty() ? Vec3::UnitY() : directions.back());
    directions.push_back(link.axis);
  }
  if (last) directions.push_back(-last->axis);

  Vec3 smooth = first ? first->axis : frames[0].axis;
  Vec3 side = first ? first->side : smooth.unitOrthogonal();
  for (std::size_t i = 0; i < links; ++i) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < directions.size(); ++k) {
      const double apart = (double(k) - double(i + offset)) / kSmooth;
      sum += std::exp(-apart * apart / 2) * directions[k];
    }
    const Vec3 next = unit_or(sum, smooth);
    side = transport(side, smooth, next);
    smooth = next;
    LinkFrame& link = frames[i];
    const Vec3 own = transport(side, smooth, link.axis);
    link.wide = i % 2 ? Vec3(link.axis.cross(own)) : own;
  }
  return frames;
}

}  // namespace taut::mesh
