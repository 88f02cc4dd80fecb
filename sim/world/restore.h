// Bringing the links of a span back to their lengths.
#pragma once

#include <vector>

#include "sim/world/connector.h"

namespace taut {

/// Moves the particles of a span as little as restores its links, all masses counted: Newton's
/// method on the lengths, in linear time. Where an end is free one step of it, as little to first
/// order, after which the links are laid at their lengths. Keeps its workspace.
class LinkRestorer {
 public:
  /// Room for so many particles.
  void reserve(std::size_t particles) { rows_.reserve(particles); }

  /// Restores the span of the link, and tells its last particle; leaves the span as it is where
  /// that fails.
  std::size_t restore(Connector& connector, std::size_t link);

 private:
  struct Row {                   // a particle, and the link behind it
    Vec3 before = Vec3::Zero();  // m, where it was
    double inverse_mass = 0;     // 1/kg, zero where something holds it
    double squared = 0;          // m^2, of the link's length at rest
    Vec3 gap = Vec3::Zero();     // m, along the link
    // The link's multiplier, and what eliminating the one before left of its equation.
    double upper = 0, value = 0;
  };
  double measure(const Connector& connector, std::size_t first, std::size_t last);
  bool solve(std::size_t first, std::size_t last);

  std::vector<Row> rows_;
};

}  // namespace taut
