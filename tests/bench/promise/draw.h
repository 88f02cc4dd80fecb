// Scenes that nobody tuned a method for, drawn from a seed.
#pragma once

#include <array>
#include <string_view>

#include "sim/world/world.h"

namespace taut::promise {

/// Another one whenever a seed draws another scene or a reference means something else.
constexpr int kVersion = 3;

constexpr std::array<std::string_view, 7> kKinds = {"plane",  "upright", "space", "driven",
                                                    "pinned", "bodies",  "flying"};

struct Drawn {
  unsigned seed = 0;
  std::size_t kind = 0;  // index into kKinds
  World world;
  double length = 0;          // m, of the longest connector
  std::size_t particles = 0;  // of the longest connector
  double ratio = 0;           // of the load's mass to that connector's
};

/// The scene of that seed; kinds take turns from seed to seed.
///
/// plane: let go straight at any angle. upright: 1 to 10 degrees from upright. space: thrown out of
/// its plane, straight or bent. driven: an end that goes round a circle or is shaken, and a point
/// mass or a stick at the other. pinned: held at both ends and pulled aside or thrown, or held at
/// an end and in its middle. bodies: a body that hangs off its axis, two bodies joined in flight,
/// or one that hangs by a chain from another that does. flying: nothing holds it.
Drawn draw(unsigned seed);

}  // namespace taut::promise
