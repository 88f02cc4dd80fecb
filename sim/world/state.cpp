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
  return !world.obstacles.empty() || !world.pairs.empty() || !world.bead_pairs.empty();
}

bool only_damps_bends(const World& world) {
  return std::ranges::all_of(world.connectors, [](const Connector& connector) {
    return !connector.pulls && !(connector.drag.across > 0 || connector.drag.along > 0) &&
           std::ranges::none_of(connector.holds, [](const Hold& h) { return !h.clamp.isZero(); }) &&
           std::ranges::all_of(connector.sections, [](const Section& section) {
             return std::isinf(section.axial_stiffness) && section.bending_stiffness == 0 &&
                    section.twisting_stiffness == 0;
           });
  });
}

bool touches_beside_more(const World& world, bool but_damping) {
  return has_contact(world) &&
         (!world.joints.empty() || has_winches(world) ||
          (has_materials(world) && !(but_damping && only_damps_bends(world))));
}

}  // namespace taut
