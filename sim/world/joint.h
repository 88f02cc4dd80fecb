// Where connectors are joined: particles that are one.
#pragma once

#include <cstddef>
#include <vector>

namespace taut {

/// Particles of connectors that share their place and velocity; its mass is the sum of theirs. Two
/// of one connector close a loop. At most one of them is held.
struct Joint {
  struct Particle {
    std::size_t connector = 0, particle = 0;
  };
  std::vector<Particle> particles;  // at least two
};

}  // namespace taut
