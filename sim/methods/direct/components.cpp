#include "sim/methods/direct/components.h"

#include <algorithm>
#include <numeric>
#include <utility>

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

/// True where nothing can move the link's ends against each other: both are prescribed, or points
/// of one body.
bool is_idle(const World& world, const Connector& connector, const SpanRange& span) {
  if (span.last - span.first > 1) return false;
  const Hold *a = hold_at(connector, span.first), *b = hold_at(connector, span.last);
  if (!a || !b) return false;
  if (is_prescribed(world, a->to)) return is_prescribed(world, b->to);
  return b->to.kind == Attachment::Kind::body && a->to.body == b->to.body;
}

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
      const SpanRange span{c, std::exchange(from, to), to};
      if (span.first == to || is_idle(world, connector, span)) return;
      for (const std::size_t end : {span.first, span.last}) {
        const Hold* hold = hold_at(connector, end);
        if (hold && !is_prescribed(world, hold->to))
          joints.emplace_back(spans.size(), hold->to.body);
      }
      spans.push_back(span);
    };
    for (const Hold& hold : connector.holds) cut(hold.particle);
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
