// Keeps World::topology what structure() tells, without a look at what has not changed.
#pragma once

#include "sim/world/world.h"

namespace taut {

/// While `change` changes one body.
void renumber_body(World& world, std::size_t body, auto change) {
  world.topology -= structure_of_body(world, body);
  change();
  world.topology += structure_of_body(world, body);
}

/// Weighs the free body again that holds something, if it is one.
inline void reweigh_and_renumber(World& world, const Attachment& by) {
  if (is_prescribed(world, by)) return;
  renumber_body(world, by.body, [&] { reweigh_holder(world, by); });
}

/// What a connector and the joints add to the topology.
inline std::uint64_t share(const World& world, std::size_t connector) {
  return structure_of_connector(world, connector) + structure_of_joints(world);
}

}  // namespace taut
