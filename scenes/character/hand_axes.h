// The directions of a hand.
#pragma once

#include "scenes/character/digit.h"

namespace taut::scenes {

/// The directions of a hand at rest, in the model's axes: from the wrist to the middle knuckle,
/// across it to the thumb's side, and out of the palm. Orthonormal, of either handedness.
struct HandAxes {
  Vec3 along, across, palm;
};

HandAxes hand_axes(const Skeleton& skeleton, Side side);

}  // namespace taut::scenes
