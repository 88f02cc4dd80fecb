// An empty hand, closed.
#pragma once

#include "scenes/character/digit.h"
#include "scenes/character/palm.h"

namespace taut::scenes {

/// An empty fist, the thumb across the fingers.
FingerTurns fist(const Model& model, const Skeleton& skeleton, Side side);

}  // namespace taut::scenes
