#include "sim/methods/direct/components.h"

#include <algorithm>
#include <numeric>

namespace taut::direct {
namespace {

/// Sets of indices that can be joined.
class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace

std::vector<Component> components(const World& world) {
  const std::size_t bodies = world.bodies.size();
  std::vector<SpanRange> spans;
  std::vector<std::pair<std::size_t, std::size_t>> joints;  // span, body
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    if (connector.model != ConnectorModel::links) continue;
    std::size_t from = 0;
    const auto cut = [&](std::size_t to) {
      if (to > from) spans.push_back({c, from, to});
      from = to;
    };
    for (const Hold& hold : connector.holds) {
      cut(hold.particle);
      if (is_prescribed(world, hold.to)) continue;
      if (!spans.empty() && spans.back().connector == c) {
        joints.emplace_back(spans.size() - 1, hold.to.body);
      }
      if (hold.particle + 1 < connector.particles())
        joints.emplace_back(spans.size(), hold.to.body);
    }
    cut(connector.particles() - 1);
  }

  Sets sets(bodies + spans.size());
  for (const auto& [span, body] : joints) sets.join(bodies + span, body);
  std::vector<Component> found;
  std::vector<std::size_t> index(bodies + spans.size(), world.bodies.size() + spans.size());
  const auto of = [&](std::size_t node) -> Component& {
    std::size_t& at = index[sets.find(node)];
    if (at >= found.size()) {
      at = found.size();
      found.emplace_back();
    }
    return found[at];
  };
  for (std::size_t s = 0; s < spans.size(); ++s) of(bodies + s).spans.push_back(spans[s]);
  for (std::size_t b = 0; b < bodies; ++b) {
    if (!world.bodies[b].driven()) of(b).bodies.push_back(b);
  }
  return found;
}

const Hold* hold_at(const Connector& connector, std::size_t particle) {
  const auto hold = std::ranges::lower_bound(connector.holds, particle, {}, &Hold::particle);
  return hold != connector.holds.end() && hold->particle == particle ? &*hold : nullptr;
}

}  // namespace taut::direct
