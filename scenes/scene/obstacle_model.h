// Models of obstacles.
#pragma once

#include "scenes/model/model.h"
#include "sim/world/shape.h"

namespace taut::scenes {

/// A model of the shape at `place`; of a plane the square of the edge `size` (m) around its origin.
Model obstacle_model(const Shape& shape, double size, const Pose& place, const Vec3& color);

}  // namespace taut::scenes
