// A kind of row of its own: a particle that slides on a fixed plane.
#pragma once

#include "sim/methods/direct/system/system.h"

namespace taut::direct {

class PlaneRow : public ConstraintRow {
 public:
  /// The plane normal . x = offset (m); `normal` is a unit vector.
  PlaneRow(Particle particle, const Vec3& normal, double offset)
      : particle_(particle), normal_(normal), offset_(offset) {}

  std::span<const Particle> particles() const override { return {&particle_, 1}; }
  Value evaluate(double, std::span<const Point> points, std::span<Vec3> gradient) const override {
    gradient[0] = normal_;
    return {.gap = normal_.dot(points[0].position) - offset_,
            .rate = normal_.dot(points[0].velocity)};
  }

 private:
  Particle particle_;
  Vec3 normal_;
  double offset_;
};

}  // namespace taut::direct
