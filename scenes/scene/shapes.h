// Models of plain solids, for bodies that name no mesh.
#pragma once

#include "scenes/model/model.h"
#include "sim/motion/types.h"

namespace taut {

// Centred on the origin; sizes in m; `color` linear.
Model cylinder_model(double length, double diameter, const Vec3& color);  // axis along y
Model sphere_model(double diameter, const Vec3& color);
Model box_model(const Vec3& size, const Vec3& color);

}  // namespace taut
