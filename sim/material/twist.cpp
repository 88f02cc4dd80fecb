#include "sim/material/twist.h"

#include "sim/motion/rotation.h"

namespace taut::material {

Carry::Carry(const Vec3& e0, const Vec3& e1)
    : inverse0_(1 / e0.norm()),
      inverse1_(1 / e1.norm()),
      t0_(inverse0_ * e0),
      t1_(inverse1_ * e1),
      share_(1 / (1 + t0_.dot(t1_))),
      slope_(share_ * t0_.cross(t1_)) {}

Bend::Stiffness Carry::second() const {
  const auto own = [&](const Mat3& by_direction, const Vec3& t) -> Mat3 {
    const Mat3 full =
        by_direction * (Mat3::Identity() - t * t.transpose()) - slope_ * t.transpose();
    return (full + full.transpose()) / 2;
  };
  const Mat3 by_t0 = share_ * (-cross_matrix(t1_) - slope_ * t1_.transpose());
  const Mat3 by_t1 = share_ * (cross_matrix(t0_) - slope_ * t0_.transpose());
  return {inverse0_ * inverse0_ * own(by_t0, t0_),
          inverse0_ * inverse1_ * by_t1 * (Mat3::Identity() - t1_ * t1_.transpose()),
          inverse1_ * inverse1_ * own(by_t1, t1_)};
}

}  // namespace taut::material
