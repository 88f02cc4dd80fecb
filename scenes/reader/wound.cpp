#include <cmath>
#include <numbers>

#include "scenes/reader/reader.h"

namespace taut::scenes {

namespace {

constexpr int kCorners = 720;         // of a turn, as a polygon around the circle
constexpr double kTurnsApart = 1.05;  // of the rope's thickness, from one turn to the next

}  // namespace

std::vector<Vec3> wound_line(const Obstacle& around, double radius, const Vec3& gravity,
                             const Winding& winding) {
  const Pose frame = around.frame(0).pose();
  const Vec3 axis = frame.rotation * Vec3::UnitY();
  Vec3 down = gravity - axis.dot(gravity) * axis;
  if (down.norm() < 1e-9 * gravity.norm() || gravity.isZero())
    down = frame.rotation * -Vec3::UnitX();
  down.normalize();
  // Right-handed about the axis; rope that comes up from below is on the side of axis x down.
  const Vec3 side = axis.cross(down);
  const double step = 2 * std::numbers::pi / kCorners;
  const double circle = (around.shape.radius + radius) / std::cos(step / 2);
  const double rise = winding.turns > 1 ? kTurnsApart * 2 * radius * winding.turns : 0;
  const int steps = std::max(1, static_cast<int>(std::lround(winding.turns * kCorners)));
  std::vector<Vec3> corners;
  for (int i = 0; i < steps; ++i) {
    const double angle = (i + 0.5) * step, share = static_cast<double>(i) / steps;
    corners.push_back(frame.position + (share - 0.5) * rise * axis +
                      circle * (std::cos(angle) * side - std::sin(angle) * down));
  }
  // Straight on, along the tangents.
  const double last = steps * step;
  corners.insert(corners.begin(), corners.front() + winding.before * down);
  corners.push_back(corners.back() -
                    winding.after * (std::sin(last) * side + std::cos(last) * down));
  return corners;
}

}  // namespace taut::scenes
