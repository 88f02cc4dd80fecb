// How much room a world has for what interventions add.
#pragma once

#include <cstddef>

#include "sim/world/world.h"

namespace taut {

/// Room for so many particles is made beforehand at most, tens of MB: every part that pins and
/// cuts may leave gets room for the whole connector, which for thousands of them no machine has.
constexpr double kMostRoom = 1e5;

/// The capacity of the connectors' arrays, all connectors together. A workspace that reserves as
/// much, once, does not grow before the world's own arrays do.
struct Room {
  std::size_t particles = 0, holds = 0;
};

inline Room room(const World& world) {
  Room sum;
  for (const Connector& connector : world.connectors) {
    sum.particles += connector.position.capacity();
    sum.holds += connector.holds.capacity();
  }
  return sum;
}

}  // namespace taut
