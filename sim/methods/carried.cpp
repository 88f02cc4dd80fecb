#include "sim/methods/carried.h"

namespace taut::methods {
namespace {

/// The moment of `by` at a carried point, in body axes.
Vec3 moment(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& by,
            const double* state) {
  const Quat rotation = quaternion(state + mechanism.pose(point.body) + 3);
  return point.local.cross(rotation.conjugate() * by);
}

}  // namespace

double mobility(const Mechanism& mechanism, std::size_t body, const Vec3& by_place,
                const Vec3& by_turn) {
  const auto& moved = mechanism.bodies()[body];
  return moved.inverse_mass * by_place.squaredNorm() + by_turn.dot(moved.inverse_inertia * by_turn);
}

double mobility(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& along,
                const double* state) {
  return mobility(mechanism, point.body, along, moment(mechanism, point, along, state));
}

void pull(const Mechanism& mechanism, std::size_t body, const Vec3& by, const Vec3& turn,
          double* state) {
  const auto& moved = mechanism.bodies()[body];
  double* q = state + mechanism.pose(body);
  const Quat rotation = quaternion(q + 3);
  Eigen::Map<Vec3> centre(q);
  centre += moved.inverse_mass * by;
  rotate(rotation * (moved.inverse_inertia * turn), q + 3);
  const Quat turned = quaternion(q + 3);
  for (const auto& other : mechanism.body_points()) {
    if (other.body != body) continue;
    Eigen::Map<Vec3> position(state + mechanism.position(other.point));
    position = centre + turned * other.local;
  }
}

void pull(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& by,
          double* state) {
  pull(mechanism, point.body, by, moment(mechanism, point, by, state), state);
}

}  // namespace taut::methods
