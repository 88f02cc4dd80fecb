#include "sim/world/state.h"

#include <algorithm>
#include <cmath>

namespace taut {

bool has_materials(const World& world) {
  return std::ranges::any_of(
      world.connectors, [](const Connector& connector) { return !connector.sections.empty(); });
}

bool has_touching_links(const World& world) {
  return !world.obstacles.empty() && std::ranges::any_of(world.connectors, &Connector::links_touch);
}

bool has_strings(const World& world) {
  return std::ranges::any_of(world.connectors, &Connector::pulls);
}

bool has_winches(const World& world) {
  return std::ranges::any_of(world.connectors,
                             [](const Connector& connector) { return connector.winch != nullptr; });
}

bool has_touching_bodies(const World& world) {
  if (!world.pairs.empty()) return true;
  return !world.obstacles.empty() && std::ranges::any_of(world.bodies, [](const Body& body) {
    return body.capsule.touches() && !body.driven();
  });
}

bool has_contact(const World& world) {
  return !world.obstacles.empty() || !world.pairs.empty() || !world.bead_pairs.empty() ||
         !world.connector_pairs.empty();
}

}  // namespace taut
