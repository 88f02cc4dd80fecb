#include "sim/topology/span.h"

#include <algorithm>

namespace taut {
namespace {

constexpr double kTaut = 1e-9;  // of the length: a span so near it is taut

SpanEnd span_end(const World& world, const Connector& connector, std::size_t particle,
                 const Hold* hold) {
  SpanEnd end;
  end.particle = particle;
  if (hold == nullptr) {
    const bool light = !(connector.particle_mass[particle] > 0);
    end.kind = light ? SpanEnd::Kind::follower : SpanEnd::Kind::particle;
    return end;
  }
  end.pin = hold->pin.number;
  if (!is_prescribed(world, hold->to)) {
    end.kind = SpanEnd::Kind::body;
    end.body = hold->to.body;
    end.point = hold->to.point;
  }
  return end;
}

Span make_span(const World& world, std::size_t c, std::size_t index, const SpanEnd& from,
               const SpanEnd& to, const std::vector<Span>& before) {
  const Connector& connector = world.connectors[c];
  Span span{c, index, from, to};
  for (std::size_t k = from.particle; k < to.particle; ++k) span.length += connector.rest[k];
  const double part = connector.length > 0 ? span.length / connector.length
                                           : static_cast<double>(span.links()) /
                                                 static_cast<double>(connector.links());
  span.mass = connector.mass * part;
  span.folds = span.links() > 1 || connector.model == ConnectorModel::span;
  const auto same = std::ranges::find_if(before, [&](const Span& old) {
    return old.connector == c && old.a.pin == from.pin && old.b.pin == to.pin &&
           old.length == span.length;
  });
  const Vec3 gap = connector.position[to.particle] - connector.position[from.particle];
  span.taut = same != before.end() ? same->taut : gap.norm() >= span.length * (1 - kTaut);
  return span;
}

}  // namespace

void divide(const World& world, const std::vector<Span>& before, std::vector<Span>& spans) {
  spans.clear();
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    const std::size_t last = connector.particles() - 1;
    SpanEnd from = span_end(world, connector, 0, nullptr);
    std::size_t index = 0;
    const auto close = [&](const SpanEnd& to) {
      if (to.particle > from.particle)
        spans.push_back(make_span(world, c, index++, from, to, before));
      from = to;
    };
    for (const Hold& hold : connector.holds)
      close(span_end(world, connector, hold.particle, &hold));
    if (from.particle < last) close(span_end(world, connector, last, nullptr));
  }
}

bool has_spans(const World& world) {
  return std::ranges::any_of(world.connectors,
                             [](const Connector& c) { return c.model == ConnectorModel::span; });
}

}  // namespace taut
