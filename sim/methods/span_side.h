// An end of a span as a thing that impulses move.
#pragma once

#include <vector>

#include "sim/motion/rotation.h"
#include "sim/topology/span.h"

namespace taut::methods {

/// A span so near its limit, as a part of its length, is at it.
constexpr double kAtLimit = 1e-12;

/// A point at `arm` from the centre of mass of a body, or a particle (arm zero). World axes.
struct Side {
  double inverse_mass = 0;              // 1/kg; zero: does not respond to impulses
  Mat3 inverse_inertia = Mat3::Zero();  // 1/(kg m^2)
  Vec3 arm = Vec3::Zero();              // m
  Vec3 spin = Vec3::Zero();             // rad/s
  Vec3* centre = nullptr;               // m, where the state keeps it
  Vec3* velocity = nullptr;             // m/s, of the centre
  Body* body = nullptr;

  Side(World& world, const Span& span, const SpanEnd& end,
       const std::vector<FreeRotation>& rotations) {
    Connector& connector = world.connectors[span.connector];
    centre = &connector.position[end.particle];
    velocity = &connector.velocity[end.particle];
    if (end.kind == SpanEnd::Kind::particle) {
      inverse_mass = 1 / connector.particle_mass[end.particle];
    } else if (end.kind == SpanEnd::Kind::body) {
      body = &world.bodies[end.body];
      centre = &body->position;
      velocity = &body->velocity;
      inverse_mass = 1 / body->mass_properties.mass;
      inverse_inertia = rotations[end.body].inverse_inertia(body->rotation);
      arm = body->point(end.point) - body->position;
      spin = body->spin;
    }
  }

  /// The arm `ago` seconds before, to second order in the turn since.
  Vec3 arm_before(double ago) const {
    const Vec3 turn = ago * spin;
    return arm - turn.cross(arm) + turn.cross(turn.cross(arm)) / 2;
  }
  Vec3 point() const { return *centre + arm; }
  Vec3 point_before(double ago) const { return *centre - ago * *velocity + arm_before(ago); }
  Vec3 fall(const Vec3& gravity) const { return inverse_mass > 0 ? gravity : Vec3(0, 0, 0); }
  Vec3 velocity_of(const Vec3& at) const { return *velocity + spin.cross(at); }

  /// The velocity that the point at `seen` gets from a unit impulse along `n` at `acting`.
  Vec3 inverse_mass_along(const Vec3& n, const Vec3& acting, const Vec3& seen) const {
    return inverse_mass * n + (inverse_inertia * acting.cross(n)).cross(seen);
  }
  /// The same as a matrix on the impulse.
  Mat3 inverse_mass_matrix(const Vec3& acting, const Vec3& seen) const {
    Mat3 matrix;
    for (int i = 0; i < 3; ++i) matrix.col(i) = inverse_mass_along(Vec3::Unit(i), acting, seen);
    return matrix;
  }

  void kick(const Vec3& impulse, const Vec3& acting) const {
    if (inverse_mass == 0) return;
    *velocity += inverse_mass * impulse;
    if (body) body->spin += inverse_inertia * acting.cross(impulse);
  }
  /// Moves it as far as an impulse has since it acted; `impulse_time` is the product, N s^2. The
  /// angular momentum stays, so that the spin changes as the inertia turns.
  void shift(const Vec3& impulse_time, const Vec3& acting) const {
    if (inverse_mass == 0) return;
    *centre += inverse_mass * impulse_time;
    if (!body) return;
    const Vec3 momentum = body->world_inertia() * body->spin;
    const Vec3 half = inverse_inertia * acting.cross(impulse_time) / 2;
    const Quat turn = Quat(1, half.x(), half.y(), half.z()).normalized();
    body->rotation = (turn * body->rotation).normalized();
    body->spin +=
        turn * (inverse_inertia * (turn.conjugate() * momentum)) - inverse_inertia * momentum;
  }
};

/// The share of a rebound left by the connector, m_a / (m_c + m_a), m_a the ends' reduced mass.
inline double mass_ratio(const Span& span, double inverse_mass) {
  return 1 / (1 + span.mass * inverse_mass);
}

}  // namespace taut::methods
