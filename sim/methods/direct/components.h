// The parts of a world that move without each other.
#pragma once

#include <cstddef>
#include <vector>

#include "sim/world.h"

namespace taut::direct {

/// The links of a connector between two neighbouring holds, or a hold and a free end.
struct SpanRange {
  std::size_t connector = 0;
  std::size_t first = 0, last = 0;  // particles
};

/// Spans and free bodies that only move together.
struct Component {
  std::vector<SpanRange> spans;
  std::vector<std::size_t> bodies;  // indices into World::bodies
};

/// Cuts a world at everything whose motion is known beforehand. Links that nothing can stretch or
/// compress are in none of the parts.
std::vector<Component> components(const World& world);

/// The hold on a particle, or null.
const Hold* hold_at(const Connector& connector, std::size_t particle);

}  // namespace taut::direct
