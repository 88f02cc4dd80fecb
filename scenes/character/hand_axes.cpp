#include "scenes/character/hand_axes.h"

namespace taut::scenes {

HandAxes hand_axes(const Skeleton& skeleton, Side side) {
  const auto joint = [&](const char* name) {
    return skeleton.rest(skeleton.find(hand_name(side) + name));
  };
  const Vec3 wrist = joint("");
  HandAxes axes;
  axes.along = (joint("Middle1") - wrist).normalized();
  const Vec3 across = joint("Index1") - joint("Pinky1");
  axes.across = (across - across.dot(axes.along) * axes.along).normalized();
  axes.palm = axes.along.cross(axes.across);
  // Thumbs lie before the palm.
  if (axes.palm.dot(joint("Thumb3") - wrist) < 0) axes.palm = -axes.palm;
  return axes;
}

}  // namespace taut::scenes
