#include "sim/methods/span.h"

namespace taut {
namespace {

SpanEnd span_end(const World& world, const Connector& connector, std::size_t particle,
                 const Attachment* to) {
  SpanEnd end;
  end.particle = particle;
  if (to == nullptr) {
    const bool light = !(connector.particle_mass[particle] > 0);
    end.kind = light ? SpanEnd::Kind::follower : SpanEnd::Kind::particle;
  } else if (!is_prescribed(world, *to)) {
    end.kind = SpanEnd::Kind::body;
    end.body = to->body;
    end.point = to->point;
  }
  return end;
}

}  // namespace

std::vector<Span> divide(const World& world) {
  std::vector<Span> spans;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    const std::size_t last = connector.particles() - 1;
    std::vector<SpanEnd> stops;
    for (const Hold& hold : connector.holds) {
      stops.push_back(span_end(world, connector, hold.particle, &hold.to));
    }
    if (stops.empty() || stops.front().particle != 0) {
      stops.insert(stops.begin(), span_end(world, connector, 0, nullptr));
    }
    if (stops.back().particle != last) {
      stops.push_back(span_end(world, connector, last, nullptr));
    }
    for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
      Span span{c, i, stops[i], stops[i + 1]};
      for (std::size_t k = span.a.particle; k < span.b.particle; ++k) {
        span.length += connector.rest[k];
      }
      const double part = connector.length > 0 ? span.length / connector.length
                                               : static_cast<double>(span.links()) /
                                                     static_cast<double>(connector.links());
      span.mass = connector.mass * part;
      const double distance =
          (connector.position[span.b.particle] - connector.position[span.a.particle]).norm();
      span.taut = distance >= span.length * (1 - 1e-9);
      spans.push_back(span);
    }
  }
  return spans;
}

}  // namespace taut
