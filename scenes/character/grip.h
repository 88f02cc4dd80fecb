// A hand closed around a stick.
#pragma once

#include <utility>
#include <vector>

#include "scenes/character/digit.h"

namespace taut::scenes {

/// The directions of a hand at rest, in the model's axes: from the wrist to the middle knuckle,
/// across it to the thumb's side, and out of the palm. Orthonormal, of either handedness.
struct HandAxes {
  Vec3 along, across, palm;
};

HandAxes hand_axes(const Skeleton& skeleton, Side side);

/// Where a held stick lies, in the model's axes at rest, from the hand's joint (m); and the turns
/// of the finger bones that hold it.
struct Grip {
  Vec3 centre, axis;  // the axis is a unit vector out of the thumb's side
  std::vector<std::pair<std::size_t, Quat>> fingers;
};

/// Lays a stick of that radius (m) on the palm, wraps the fingers round it until the skin of their
/// phalanges touches it, and the thumb from the other side. The skin is `model`'s.
Grip grip_stick(const Model& model, const Skeleton& skeleton, Side side, double radius);

/// An empty fist, the thumb across the fingers.
std::vector<std::pair<std::size_t, Quat>> fist(const Model& model, const Skeleton& skeleton,
                                               Side side);

}  // namespace taut::scenes
