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

}  // namespace taut
