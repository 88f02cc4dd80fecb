#include "sim/methods/carried.h"

namespace taut::methods {

double mobility(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& along,
                const double* state) {
  const auto& body = mechanism.bodies()[point.body];
  const Quat rotation = quaternion(state + mechanism.pose(point.body) + 3);
  const Vec3 lever = point.local.cross(rotation.conjugate() * along);  // in body axes
  return body.inverse_mass * along.squaredNorm() + lever.dot(body.inverse_inertia * lever);
}

void pull(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& by,
          double* state) {
  const auto& body = mechanism.bodies()[point.body];
  double* q = state + mechanism.pose(point.body);
  const Quat rotation = quaternion(q + 3);
  const Vec3 lever = point.local.cross(rotation.conjugate() * by);
  Eigen::Map<Vec3> centre(q);
  centre += body.inverse_mass * by;
  rotate(rotation * (body.inverse_inertia * lever), q + 3);
  const Quat turned = quaternion(q + 3);
  for (const auto& other : mechanism.body_points()) {
    if (other.body != point.body) continue;
    Eigen::Map<Vec3> position(state + mechanism.position(other.point));
    position = centre + turned * other.local;
  }
}

}  // namespace taut::methods
