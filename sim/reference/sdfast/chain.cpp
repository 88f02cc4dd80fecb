#include "sim/reference/sdfast/chain.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace taut::sdfast {
namespace {

void require(bool holds, const char* otherwise) {
  if (!holds) throw std::invalid_argument(otherwise);
}

}  // namespace

Chain find_chain(const World& world) {
  require(world.connectors.size() == 1, "follows one connector alone");
  const Connector& connector = world.connectors.front();
  require(connector.model == ConnectorModel::links, "follows links, not massless spans");
  require(std::ranges::min(connector.rest) > 0, "follows no links without length");
  Chain chain;
  chain.links = connector.links();
  const Hold *first = nullptr, *last = nullptr;
  for (const Hold& hold : connector.holds) {
    const bool at_end = hold.particle == 0 || hold.particle == chain.links;
    require(at_end, "follows no chain that is pinned between its ends");
    require(hold.to.approach.arrival <= world.time, "follows no end that is being drawn to a pin");
    (hold.particle == 0 ? first : last) = &hold;
  }
  const auto known = [&](const Hold* hold) { return hold && is_prescribed(world, hold->to); };
  require(!known(first) || !known(last), "follows no chain whose two ends move as they are told");
  chain.reversed = known(last);
  if (chain.reversed) std::swap(first, last);
  if (first) (known(first) ? chain.held : chain.base) = first->to;
  if (last) chain.tip = last->to;
  require(!chain.base || !chain.tip || chain.base->body != chain.tip->body,
          "follows no chain whose two ends one body holds");
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    const bool carries =
        (chain.base && chain.base->body == b) || (chain.tip && chain.tip->body == b);
    require(world.bodies[b].driven() || carries, "follows no body beside the chain");
  }
  for (std::size_t i = 0; i <= chain.links; ++i) {
    const bool carried = i == 0 ? chain.held || chain.base : i == chain.links && chain.tip;
    require(carried || connector.particle_mass[chain.particle(i)] > 0,
            "follows no particles without mass");
  }
  return chain;
}

}  // namespace taut::sdfast
