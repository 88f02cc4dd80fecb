// The parts of a world that move without each other.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sim/world/world.h"

namespace taut {

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

}  // namespace taut
