// The parts of a world that move without each other: its components, the pieces of cut connectors,
// and the spans of connectors between held particles.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "sim/world/connector.h"
#include "sim/world/world.h"

namespace taut {

// Where the connectors that a world had at its start are, once some of them are cut.

/// Each connector of the start is one part or, where it was cut, several in a row. Places are m of
/// its length at the start, from its first particle.
class Parts {
 public:
  explicit Parts(std::span<const Connector> start);

  struct Place {
    std::size_t connector = 0;  // of those that there are now
    double along = 0;           // m on it
  };
  Place at(std::size_t whole, double along) const;

  /// Notes that `connector` is new, and has all of what followed the place until the next cut.
  void cut(std::size_t whole, double along, std::size_t connector);

  struct Part {
    std::size_t whole = 0, connector = 0;
    double start = 0, end = 0;  // m on the whole
  };
  /// In the order in which they came to be: the connectors of the start first.
  const std::vector<Part>& all() const { return parts_; }
  /// The parts' indices as they follow each other, connector by connector of the start.
  std::vector<std::size_t> in_a_row() const;

 private:
  std::size_t part(std::size_t whole, double along) const;

  std::vector<Part> parts_;
  std::vector<std::multimap<double, std::size_t>> of_;  // [whole] its parts by where they start
};

// How much room a world has for what interventions add.

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

/// The links of a connector between two neighbouring holds, or a hold and a free end.
struct SpanRange {
  std::size_t connector = 0;
  std::size_t first = 0, last = 0;  // particles
};

/// Spans and free bodies that only move together.
struct Component {
  std::span<const SpanRange> spans;
  std::span<const std::size_t> bodies;  // indices into World::bodies
};

/// Divides worlds. Keeps its workspace.
class Division {
 public:
  /// Cuts a world at everything whose motion is known beforehand. Links that nothing can stretch or
  /// compress are in none of the parts. They stay until the next call.
  std::span<const Component> divide(const World& world);

 private:
  struct Joint {
    std::size_t span = 0, body = 0;
  };
  struct Part {  // how much of the arrays is a component's, and where the next of it goes
    std::size_t spans = 0, bodies = 0;
    SpanRange* next_span = nullptr;
    std::size_t* next_body = nullptr;
  };
  void reserve(const World& world);
  void collect(const World& world);
  /// The node that stands for all that are joined with this one; bodies come first, then spans.
  std::size_t find(std::size_t node);
  std::size_t part_of(std::size_t node);

  std::size_t room_ = 0;  // nodes
  std::vector<SpanRange> spans_, sorted_spans_;
  std::vector<Joint> joints_;
  std::vector<std::size_t> parent_, index_, sorted_bodies_;
  std::vector<Part> parts_;
  std::vector<Component> found_;
};

/// True where what holds a particle stands still from `time` (s) on: a fixed point, once the
/// particle has been drawn there.
inline bool rests(const Attachment& to, double time) {
  return to.kind == Attachment::Kind::fixed && time >= to.approach.arrival;
}

/// The hold on a particle, or null.
const Hold* find_hold(const Connector& connector, std::size_t particle);

/// True where nothing can move two holds against each other: both are prescribed, or points of one
/// body.
bool move_as_one(const World& world, const Hold& a, const Hold& b);

/// Calls `visit` with every span of a connector that something can move, and the holds at its ends
/// or null, one after another. A single link between holds that move as one is none of them.
template <typename Visit>
void each_span(const World& world, std::size_t index, const Visit& visit) {
  const Connector& connector = world.connectors[index];
  if (connector.model != ConnectorModel::links) return;
  const Hold* before = nullptr;
  const auto until = [&](std::size_t last, const Hold* hold) {
    const std::size_t first = before ? before->particle : 0;
    const bool idle = last == first + 1 && before && hold && move_as_one(world, *before, *hold);
    if (last > first && !idle) visit(SpanRange{index, first, last}, before, hold);
    before = hold;
  };
  for (const Hold& hold : connector.holds) until(hold.particle, &hold);
  if (!before || before->particle < connector.links()) until(connector.links(), nullptr);
}

// Spans: the parts of a connector between held particles.

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
