// Chains of fewer particles that stand for another.
#pragma once

#include "sim/world/world.h"

namespace taut {

/// Gives the particles of `world`'s connectors the masses of `exact`'s, which must have the same
/// connectors: each particle's mass goes to the two particles on either side of its place along the
/// coarser chain, in the proportion that keeps the centre of mass. So a chain of h-long links
/// differs from the exact one by O(h^2), where equal masses differ by O(h). What has no mass there
/// gets none.
void take_masses(World& world, const World& exact);

}  // namespace taut
