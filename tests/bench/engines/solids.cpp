#include "tests/bench/engines/solids.h"

#include <stdexcept>

#include "sim/motion/rotation.h"

namespace taut::engines {

void check_solid(const Obstacle& obstacle) {
  if (obstacle.static_friction != obstacle.kinetic_friction) {
    throw std::invalid_argument("engines are given one coefficient of friction");
  }
}

Quat with_axis_along_z(const Shape& shape, const Quat& rotation) {
  if (shape.kind == Shape::Kind::sphere || shape.kind == Shape::Kind::box) return rotation;
  return rotation * rotation_between(Vec3::UnitZ(), Vec3::UnitY());
}

}  // namespace taut::engines
