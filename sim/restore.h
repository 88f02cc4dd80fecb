// Bringing the links of a span back to their lengths.
#pragma once

#include <vector>

#include "sim/connector.h"

namespace taut {

/// Moves the particles of a span as little as restores its links, all masses counted: Newton's
/// method on the lengths, in linear time. Keeps its workspace.
class LinkRestorer {
 public:
  /// Room for so many particles.
  void reserve(std::size_t particles) { rows_.reserve(particles); }

  /// Restores the span of the link; leaves it as it is where that fails.
  void restore(Connector& connector, std::size_t link);

 private:
  struct Row {  // a link's multiplier, and what eliminating the one before left of its equation
    double upper = 0, value = 0;
    Vec3 before = Vec3::Zero();  // m, its first particle's place
  };
  std::vector<Row> rows_;
};

}  // namespace taut
