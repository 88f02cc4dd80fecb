// A kind of row of its own: a rigid rod without mass between two particles.
#pragma once

#include <array>

#include "sim/methods/direct/system/system.h"

namespace taut::direct {

class RodRow : public ConstraintRow {
 public:
  RodRow(Particle a, Particle b, double length) : particles_{a, b}, length_(length) {}

  std::span<const Particle> particles() const override { return particles_; }
  Value evaluate(double, std::span<const Point> points, std::span<Vec3> gradient) const override {
    const Vec3 along = points[1].position - points[0].position;
    const Vec3 apart = points[1].velocity - points[0].velocity;
    const double length = along.norm(), rate = along.dot(apart) / length;
    gradient[1] = along / length;
    gradient[0] = -gradient[1];
    return {.gap = length - length_,
            .rate = rate,
            .velocity_term = (apart.squaredNorm() - rate * rate) / length};
  }

 private:
  std::array<Particle, 2> particles_;
  double length_;  // m
};

}  // namespace taut::direct
