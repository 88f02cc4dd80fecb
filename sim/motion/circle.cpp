#include "sim/motion/circle.h"

#include <algorithm>
#include <numbers>

namespace taut {

FrameMotion motion(const Circle& circle, double time) {
  const double speed = 2 * std::numbers::pi * circle.frequency;  // rad/s, after the ramp
  const double u = std::clamp(time / circle.ramp, 0.0, 1.0);
  const double after = std::max(time - circle.ramp, 0.0);
  const double angle = speed * (circle.ramp * u * u * u * (1 - u / 2) + after);
  const Vec3 spin = speed * u * u * (3 - 2 * u) * circle.axis;
  const Vec3 spin_rate = speed / circle.ramp * 6 * u * (1 - u) * circle.axis;

  const Vec3 radius = Eigen::AngleAxisd(angle, circle.axis) * (circle.start - circle.centre);
  FrameMotion motion;
  motion.position = circle.centre + radius;
  motion.velocity = spin.cross(radius);
  motion.acceleration = spin_rate.cross(radius) + spin.cross(motion.velocity);
  return motion;
}

}  // namespace taut
