// How deep anything is in an obstacle.
#pragma once

#include "sim/world/world.h"

namespace taut::contact {

/// How deep (m) the bead or the free body's capsule is that is deepest in an obstacle; zero where
/// none is in one.
double penetration_max(const World& world);

}  // namespace taut::contact
