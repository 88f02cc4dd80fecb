// Coulomb's law for what is pushed out of an obstacle.
#pragma once

#include <algorithm>

#include "sim/world/world.h"

namespace taut::contact {

/// By how much of its length something that slides by `slip` is held back, if it can be by `push`
/// times the coefficient of friction.
inline double held_share(const Obstacle& obstacle, double slip, double push) {
  if (slip <= obstacle.static_friction * push) return 1;
  return std::min(1.0, obstacle.kinetic_friction * push / slip);
}

}  // namespace taut::contact
