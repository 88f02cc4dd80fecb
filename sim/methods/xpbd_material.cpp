#include "sim/methods/xpbd_material.h"

#include <algorithm>
#include <cmath>

#include "sim/material/elements.h"
#include "sim/methods/carried.h"

namespace taut::methods {

void XpbdMaterial::rebuild(const Mechanism& mechanism) {
  const material::MaterialForces& material = mechanism.material();
  any_ = material.any();
  if (!any_) return;
  multiplier_.reserve(2 * (mechanism.state_room() / 6));
  multiplier_.assign(
      material.stretches().size() + material.bends().size() + material.twists().size(), 0.0);
  started_.reserve(mechanism.state_room());
  force_.reserve(mechanism.state_room() / 6);
  force_.resize(mechanism.points());
  carried_.clear();
  if (mechanism.body_points().empty()) return;
  carried_.assign(mechanism.points(), kNone);
  for (std::size_t i = 0; i < mechanism.body_points().size(); ++i) {
    carried_[mechanism.body_points()[i].point] = static_cast<std::uint32_t>(i);
  }
}

void XpbdMaterial::blow(const Mechanism& mechanism, double dt, std::vector<double>& state) {
  if (mechanism.material().drags().empty()) return;
  std::ranges::fill(force_, Vec3::Zero());
  mechanism.material().add_drag(state.data(), &state[mechanism.velocity(0)], force_);
  for (std::size_t p = 0; p < mechanism.points(); ++p) {
    Eigen::Map<Vec3> velocity(&state[mechanism.velocity(p)]);
    velocity += dt * mechanism.inverse_mass()[p] * force_[p];
  }
  for (const Mechanism::BodyPoint& at : mechanism.body_points()) {
    const Mechanism::FreeBody& body = mechanism.bodies()[at.body];
    const Quat rotation = quaternion(&state[mechanism.pose(at.body) + 3]);
    const Vec3 torque = at.local.cross(rotation.conjugate() * force_[at.point]);  // body axes
    Eigen::Map<Vec3> velocity(&state[mechanism.twist(at.body)]);
    Eigen::Map<Vec3> spin(&state[mechanism.twist(at.body) + 3]);
    velocity += dt * body.inverse_mass * force_[at.point];
    spin += dt * (rotation * (body.inverse_inertia * torque));
  }
}

void XpbdMaterial::begin(const std::vector<double>& started) {
  started_ = started;
  std::ranges::fill(multiplier_, 0.0);
}

template <std::size_t N>
void XpbdMaterial::project(const Mechanism& mechanism, double dt, double stiffness, double damping,
                           double value, const Change (&changes)[N], double& multiplier,
                           double* state) {
  double easy = 0, since = 0;  // of C: its mobility (1/kg), and how it has changed in the step
  for (const Change& change : changes) {
    const Mechanism::BodyPoint* body_point = carried(mechanism, change.point);
    easy += body_point ? mobility(mechanism, *body_point, change.gradient, state)
                       : mechanism.inverse_mass()[change.point] * change.gradient.squaredNorm();
    const std::size_t at = mechanism.position(change.point);
    since += change.gradient.dot(Eigen::Map<const Vec3>(state + at) -
                                 Eigen::Map<const Vec3>(&started_[at]));
  }
  const double hard = stiffness * dt * dt, slow = damping * dt;  // kg
  const double more = -(hard * value + multiplier + slow * since) / (1 + (hard + slow) * easy);
  multiplier += more;
  for (const Change& change : changes) {
    if (const Mechanism::BodyPoint* body_point = carried(mechanism, change.point)) {
      pull(mechanism, *body_point, more * change.gradient, state);
      continue;
    }
    Eigen::Map<Vec3> position(state + mechanism.position(change.point));
    position += more * mechanism.inverse_mass()[change.point] * change.gradient;
  }
}

void XpbdMaterial::pass(const Mechanism& mechanism, double dt, double* state) {
  const material::MaterialForces& material = mechanism.material();
  double* multiplier = multiplier_.data();
  for (const material::StretchElement& link : material.stretches()) {
    const Vec3 gap = Eigen::Map<const Vec3>(state + mechanism.position(link.b)) -
                     Eigen::Map<const Vec3>(state + mechanism.position(link.a));
    const double length = gap.norm();
    if (length > 0 && (!link.pulls || length > link.rest)) {
      const Vec3 unit = gap / length;
      project<2>(mechanism, dt, link.stiffness, link.damping, length - link.rest,
                 {{link.a, -unit}, {link.b, unit}}, *multiplier, state);
    }
    ++multiplier;
  }
  Vec3 e0, e1, by_e0, by_e1;
  for (const material::BendElement& bend : material.bends()) {
    material.edges(bend, state, e0, e1);
    const material::Bend shape(e0, e1, bend.rest);
    // The gradient of C is that of C^2 / 2 over C.
    const double value = std::sqrt(2 * shape.energy(1));
    if (value > 0) {
      shape.slope(1 / value, by_e0, by_e1);
      if (bend.clamped_before()) by_e0.setZero();
      if (bend.clamped_behind()) by_e1.setZero();
      const Vec3 middle = by_e0 - by_e1;
      project<3>(mechanism, dt, bend.stiffness, bend.damping, value,
                 {{bend.a, -by_e0}, {bend.b, middle}, {bend.c, by_e1}}, *multiplier, state);
    }
    ++multiplier;
  }
  for (const material::TwistElement& rod : material.twists()) {
    material.twist_slope(rod, state, force_);
    project_twist(mechanism, dt, rod, *multiplier++, state);
  }
}

/// The same for a constraint with all particles of a connector, its gradient in `force_`.
void XpbdMaterial::project_twist(const Mechanism& mechanism, double dt,
                                 const material::TwistElement& rod, double& multiplier,
                                 double* state) {
  double mobility = 0, since = 0;
  const auto each = [&](auto visit) {
    for (std::uint32_t i = 0; i <= rod.links; ++i) {
      const std::uint32_t point = mechanism.material().point_of(rod, i);
      visit(point, mechanism.position(point), force_[i]);
    }
  };
  each([&](std::uint32_t point, std::size_t at, const Vec3& gradient) {
    mobility += mechanism.inverse_mass()[point] * gradient.squaredNorm();
    since +=
        gradient.dot(Eigen::Map<const Vec3>(state + at) - Eigen::Map<const Vec3>(&started_[at]));
  });
  const double value = mechanism.material().twist(rod, state);
  const double hard = rod.stiffness * dt * dt, slow = rod.damping * dt;
  const double more = -(hard * value + multiplier + slow * since) / (1 + (hard + slow) * mobility);
  multiplier += more;
  each([&](std::uint32_t point, std::size_t at, const Vec3& gradient) {
    Eigen::Map<Vec3> position(state + at);
    position += more * mechanism.inverse_mass()[point] * gradient;
  });
}

}  // namespace taut::methods
