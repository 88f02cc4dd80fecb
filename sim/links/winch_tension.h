// The pull of a rope at the winch that pays it out.
#pragma once

#include <cstddef>

#include "sim/world/world.h"

namespace taut {

/// The tension (N) at the drum of the winch at a connector's first (0) or last (1) end, with the
/// world's motion as it is: the load of the drum's brake or motor, the inertia of the drum and of
/// rope still wound on it aside. Solves for all tensions of the world. Positive where the rope
/// pulls. sim/winch/README.md has the equation. Throws std::invalid_argument without such a winch.
double winch_tension(const World& world, std::size_t connector, std::size_t end);

}  // namespace taut
