// A hand closed around a stick.
#pragma once

#include "scenes/character/hand_axes.h"
#include "scenes/character/palm.h"

namespace taut::scenes {

/// Where a held stick lies, in the model's axes at rest, from the hand's joint (m); and the turns
/// of the finger bones that hold it.
struct Grip {
  Vec3 centre, axis;  // the axis is a unit vector out of the thumb's side
  FingerTurns fingers;
};

/// Lays a stick of that radius (m) on the palm, wraps the fingers round it until the skin of their
/// phalanges touches it, and the thumb from the other side. The skin is `model`'s.
Grip grip_stick(const Model& model, const Skeleton& skeleton, Side side, double radius);

}  // namespace taut::scenes
