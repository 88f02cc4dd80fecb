#include "sim/motion/circle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace taut {

FrameMotion motion(const Circle& circle, double time) {
  const double speed = 2 * std::numbers::pi * circle.frequency;  // rad/s, after the ramp
  const double u = std::clamp(time / circle.ramp, 0.0, 1.0);
  const double after = std::max(time - circle.ramp, 0.0);
  const double angle = speed * (circle.ramp * u * u * u * (1 - u / 2) + after);
  const double rate = speed * u * u * (3 - 2 * u);            // rad/s
  const double gain = speed / circle.ramp * 6 * u * (1 - u);  // rad/s^2
  const double cosine = std::cos(angle), sine = std::sin(angle);
  const Vec3 first = circle.start - circle.centre, across = circle.axis.cross(first);
  const Vec3 radius = cosine * first + sine * across, tangent = cosine * across - sine * first;

  FrameMotion motion;
  motion.position = circle.centre + radius;
  motion.velocity = rate * tangent;
  motion.acceleration = gain * tangent - rate * rate * radius;
  return motion;
}

}  // namespace taut
