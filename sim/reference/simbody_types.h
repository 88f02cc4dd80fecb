// A world's counterparts in Simbody: vectors, rotations, masses, held points.
#pragma once

#include <Simbody.h>

#include <algorithm>
#include <utility>

#include "sim/motion/rotation.h"
#include "sim/world/world.h"

namespace taut::reference {

inline SimTK::Vec3 to_simbody(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
inline Vec3 from_simbody(const SimTK::Vec3& v) {
  return {v[0], v[1], v[2]};
}

inline SimTK::Rotation to_simbody(const Quat& q) {
  return SimTK::Rotation(SimTK::Quaternion(q.w(), q.x(), q.y(), q.z()));
}

/// A rotation that takes z to `direction` (a unit vector, or zero for none).
inline Quat turn_z_to(const Vec3& direction) {
  return direction.isZero() ? Quat::Identity() : rotation_between(Vec3::UnitZ(), direction);
}

/// A rigid body about its centre of mass.
inline SimTK::Body::Rigid rigid(const MassProperties& mass) {
  const Mat3& i = mass.inertia;
  return SimTK::Body::Rigid(
      SimTK::MassProperties(mass.mass, SimTK::Vec3(0),
                            SimTK::Inertia(i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2))));
}

inline SimTK::Body::Rigid point_mass(double mass) {
  return SimTK::Body::Rigid(SimTK::MassProperties(mass, SimTK::Vec3(0), SimTK::Inertia(0)));
}

/// The motion of a point that is held where it is known beforehand.
class HeldMotion final : public SimTK::Motion::Custom::Implementation {
 public:
  HeldMotion(const World* const* world, Attachment to) : world_(world), to_(std::move(to)) {}

  SimTK::Motion::Level getLevel(const SimTK::State&) const override {
    return SimTK::Motion::Position;
  }
  void calcPrescribedPosition(const SimTK::State& state, int, SimTK::Real* q) const override {
    copy(at(state).position, q);
  }
  void calcPrescribedPositionDot(const SimTK::State& state, int, SimTK::Real* q) const override {
    copy(at(state).velocity, q);
  }
  void calcPrescribedPositionDotDot(const SimTK::State& state, int, SimTK::Real* q) const override {
    copy(at(state).acceleration, q);
  }

 private:
  PointMotion at(const SimTK::State& state) const {
    return hold_motion(**world_, to_, state.getTime());
  }
  static void copy(const Vec3& from, SimTK::Real* to) { std::copy_n(from.data(), 3, to); }

  const World* const* world_;
  Attachment to_;
};

}  // namespace taut::reference
