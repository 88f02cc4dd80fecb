// Obstacles as engines can have them.
#pragma once

#include "sim/world/obstacle.h"

namespace taut::engines {

/// Throws std::invalid_argument with the reason where no engine is given it.
void check_solid(const Obstacle& obstacle);

/// The rotation of a shape whose axis is along z, where that of taut's is along y.
Quat with_axis_along_z(const Shape& shape, const Quat& rotation);

}  // namespace taut::engines
