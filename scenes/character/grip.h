// A hand closed around a stick.
#pragma once

#include <utility>
#include <vector>

#include "scenes/character/skeleton.h"

namespace taut {

enum class Side { left, right };

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

/// Closes the fingers joint by joint until the skin of each phalanx touches a stick of that radius
/// (m) in the palm, then lays the thumb over it. The skin is `model`'s.
Grip grip_stick(const Model& model, const Skeleton& skeleton, Side side, double radius);

/// An empty fist.
std::vector<std::pair<std::size_t, Quat>> fist(const Skeleton& skeleton, Side side);

}  // namespace taut
