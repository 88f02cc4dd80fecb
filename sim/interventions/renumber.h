// Keeps World::topology what structure() tells, without a look at what has not changed.
#pragma once

#include "sim/world/ties.h"

namespace taut {

/// Weighs a free body with all that it holds.
inline void reweigh_and_renumber(World& world, const Ties& ties, std::size_t body) {
  world.topology -= structure_of_body(world, body);
  reweigh(world.bodies[body], ties.laden(world, body));
  world.topology += structure_of_body(world, body);
}

}  // namespace taut
