// Where pins are.
#pragma once

#include "sim/world/world.h"

namespace taut {

struct PinnedHold {
  Connector* connector = nullptr;
  std::size_t hold = 0;
};

/// The hold of a pin, or null; looks at the connector `first` before the others.
inline PinnedHold find_pin(World& world, std::uint64_t pin, std::size_t first) {
  if (pin == 0) return {};
  const auto find_on = [&](Connector& connector) -> PinnedHold {
    for (std::size_t h = 0; h < connector.holds.size(); ++h) {
      if (connector.holds[h].pin.number == pin) return {&connector, h};
    }
    return {};
  };
  if (first < world.connectors.size()) {
    if (const PinnedHold found = find_on(world.connectors[first]); found.connector) return found;
  }
  for (Connector& connector : world.connectors) {
    if (const PinnedHold found = find_on(connector); found.connector) return found;
  }
  return {};
}

}  // namespace taut
