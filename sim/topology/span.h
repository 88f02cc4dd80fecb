// Spans: the parts of a connector between held particles.
#pragma once

#include <vector>

#include "sim/world/world.h"

namespace taut {

/// The carrier of an end of a span.
struct SpanEnd {
  enum class Kind {
    prescribed,  // a fixed point, a path or a driven body: moves as it is told
    body,        // a point of a free body
    particle,    // a free particle with mass
    follower,    // a free particle without: takes no part
  };
  Kind kind = Kind::prescribed;
  std::size_t particle = 0;
  std::uint64_t pin = 0;      // its number, where it is one
  std::size_t body = 0;       // Kind::body
  Vec3 point = Vec3::Zero();  // m, body frame
};

struct Span {
  std::size_t connector = 0;
  std::size_t index = 0;  // on its connector
  SpanEnd a, b;
  double length = 0;  // m, the sum of the rest lengths
  double mass = 0;    // kg, its share of the connector's
  bool taut = false;
  bool folds = false;  // its ends may come nearer to each other: it is no single rigid link

  std::size_t links() const { return b.particle - a.particle; }
};

/// Fills `spans` with all spans of a world, connector by connector. A span between the same ends as
/// one of `before` is as taut as that; another is taut where its ends are as far apart as it is
/// long.
void divide(const World& world, const std::vector<Span>& before, std::vector<Span>& spans);

/// True where `world` has a connector that is a massless span.
bool has_spans(const World& world);

}  // namespace taut
