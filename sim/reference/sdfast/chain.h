// A world as SD/FAST's models see it: one chain from its base to its tip.
#pragma once

#include <optional>

#include "sim/world/world.h"

namespace taut::sdfast {

/// The only connector of a world, counted from what holds it where its motion is known beforehand,
/// otherwise from its first particle.
struct Chain {
  std::optional<Attachment> held;       // of the base, where its motion is known beforehand
  std::optional<Attachment> base, tip;  // on free bodies
  bool reversed = false;
  std::size_t links = 0;

  std::size_t particle(std::size_t i) const { return reversed ? links - i : i; }
  std::size_t link(std::size_t k) const { return reversed ? links - 1 - k : k; }
};

/// The chain of `world`. Throws std::invalid_argument that says what no model follows.
Chain find_chain(const World& world);

}  // namespace taut::sdfast
