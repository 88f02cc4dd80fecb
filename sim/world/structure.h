// The structure of a world: what moves in no step, as one number.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/world/state.h"

namespace taut {

/// A hash of all that moves in no step: connectors with their rest lengths and masses, what holds
/// them, joins them and turns beside them, bodies with their mass properties, paths, obstacles,
/// pairs. Methods build on it, so World::topology is this number, which refresh() takes anew.
std::uint64_t structure(const World& world);

/// The terms of a body, a connector, a joint and a pair of beads in structure(), a sum modulo 2^64:
/// so that the topology follows a change of a few of them without a look at the others.
std::uint64_t structure_of_body(const World& world, std::size_t body);
std::uint64_t structure_of_connector(const World& world, std::size_t connector);
std::uint64_t structure_of_joint(const World& world, std::size_t joint);
std::uint64_t structure_of_bead_pair(const World& world, std::size_t pair);
std::uint64_t structure_of_connector_pair(const World& world, std::size_t pair);

}  // namespace taut
