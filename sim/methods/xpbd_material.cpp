#include "sim/methods/xpbd_material.h"

#include <cmath>

#include "sim/material/elements.h"
#include "sim/methods/carried.h"

namespace taut::methods {
namespace {

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

}  // namespace

void XpbdMaterial::rebuild(const Mechanism& mechanism) {
  const material::MaterialForces& material = mechanism.material();
  any_ = material.any();
  if (!any_) return;
  multiplier_.reserve(2 * (mechanism.state_room() / 6));
  multiplier_.assign(
      material.stretches().size() + material.bends().size() + material.twists().size(), 0.0);
  damper_.reserve(multiplier_.capacity());
  damper_.assign(multiplier_.size(), 0.0);
  const auto damps = [](const auto& element) { return element.damping > 0; };
  damps_ = std::ranges::any_of(material.stretches(), damps) ||
           std::ranges::any_of(material.bends(), damps) ||
           std::ranges::any_of(material.twists(), damps);
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

void XpbdMaterial::begin() {
  std::ranges::fill(multiplier_, 0.0);
}

XpbdMaterial::BodyChange& XpbdMaterial::change_of(std::uint32_t body, Constraint& in) {
  for (std::size_t b = 0; b < in.bodies; ++b)
    if (in.body[b].body == body) return in.body[b];
  in.body[in.bodies] = {.body = body};
  return in.body[in.bodies++];
}

void XpbdMaterial::add(const Mechanism& mechanism, std::uint32_t point, const Vec3& gradient,
                       const double* state, Constraint& to) const {
  if (const Mechanism::BodyPoint* at = carried(mechanism, point)) {
    BodyChange& body = change_of(at->body, to);
    const Quat rotation = quaternion(state + mechanism.pose(at->body) + 3);
    body.by_place += gradient;
    body.by_turn += at->local.cross(rotation.conjugate() * gradient);
  } else {
    to.point[to.points++] = {point, gradient};
    to.mobility += mechanism.inverse_mass()[point] * gradient.squaredNorm();
  }
}

/// False where C is no matter there: a string is slack, or has no direction.
bool XpbdMaterial::measure(const Mechanism& mechanism, const material::StretchElement& link,
                           const double* state, Constraint& made) const {
  const Vec3 gap =
      ConstMap(state + mechanism.position(link.b)) - ConstMap(state + mechanism.position(link.a));
  const double length = gap.norm();
  if (!(length > 0) || (link.pulls && length <= link.rest)) return false;
  const Vec3 unit = gap / length;
  made.value = length - link.rest;
  made.pulls = link.pulls;
  if (link.rest_rate != 0) made.given = length / link.rest * link.rest_rate;
  add(mechanism, link.a, -unit, state, made);
  add(mechanism, link.b, unit, state, made);
  return true;
}

bool XpbdMaterial::measure(const Mechanism& mechanism, const material::BendElement& bend,
                           const double* state, Constraint& made) const {
  Vec3 e0, e1, by_e0, by_e1;
  mechanism.material().edges(bend, state, e0, e1);
  const auto clamp = mechanism.clamp_on_body(bend);
  if (clamp) {  // turned since the last place()
    (bend.clamped_before() ? e0 : e1) =
        quaternion(state + mechanism.pose(clamp->body) + 3) * clamp->local;
  }
  const material::Bend shape(e0, e1, bend.rest);
  // The gradient of C is that of C^2 / 2 over C.
  made.value = std::sqrt(2 * shape.energy(1));
  if (!(made.value > 0)) return false;
  shape.slope(1 / made.value, by_e0, by_e1);
  if (clamp) {
    const Quat rotation = quaternion(state + mechanism.pose(clamp->body) + 3);
    const Vec3& gradient = bend.clamped_before() ? by_e0 : by_e1;
    change_of(clamp->body, made).by_turn += clamp->local.cross(rotation.conjugate() * gradient);
  }
  if (bend.clamped_before()) by_e0.setZero();
  if (bend.clamped_behind()) by_e1.setZero();
  if (!bend.clamped_before()) add(mechanism, bend.a, -by_e0, state, made);
  add(mechanism, bend.b, by_e0 - by_e1, state, made);
  if (!bend.clamped_behind()) add(mechanism, bend.c, by_e1, state, made);
  return true;
}

void XpbdMaterial::pass(const Mechanism& mechanism, double dt, double* state) {
  const material::MaterialForces& material = mechanism.material();
  double* multiplier = multiplier_.data();
  const auto project = [&](const auto& element) {
    Constraint at;
    double& sum = *multiplier++;
    if (!measure(mechanism, element, state, at)) return;
    for (std::size_t b = 0; b < at.bodies; ++b)
      at.mobility += mobility(mechanism, at.body[b].body, at.body[b].by_place, at.body[b].by_turn);
    const double hard = element.stiffness * dt * dt;  // kg
    const double more = -(hard * at.value + sum) / (1 + hard * at.mobility);
    sum += more;
    for (std::size_t p = 0; p < at.points; ++p) {
      const auto& [point, gradient] = at.point[p];
      Map(state + mechanism.position(point)) += more * mechanism.inverse_mass()[point] * gradient;
    }
    for (std::size_t b = 0; b < at.bodies; ++b) {
      pull(mechanism, at.body[b].body, more * at.body[b].by_place, more * at.body[b].by_turn,
           state);
    }
  };
  for (const material::StretchElement& link : material.stretches()) project(link);
  for (const material::BendElement& bend : material.bends()) project(bend);
  for (const material::TwistElement& rod : material.twists()) {
    material.twist_slope(rod, state, force_);
    double mobility = 0;
    for (std::uint32_t i = 0; i <= rod.links; ++i)
      mobility += mechanism.inverse_mass()[material.point_of(rod, i)] * force_[i].squaredNorm();
    const double hard = rod.stiffness * dt * dt;
    double& sum = *multiplier++;
    const double more = -(hard * material.twist(rod, state) + sum) / (1 + hard * mobility);
    sum += more;
    for (std::uint32_t i = 0; i <= rod.links; ++i) {
      const std::uint32_t point = material.point_of(rod, i);
      Map(state + mechanism.position(point)) += more * mechanism.inverse_mass()[point] * force_[i];
    }
  }
}

void XpbdMaterial::damp(const Mechanism& mechanism, double dt, double* state) {
  const material::MaterialForces& material = mechanism.material();
  const double* multiplier = multiplier_.data();
  double* damper = damper_.data();
  const auto slow = [&](const auto& element) {
    Constraint at;
    const double pulled = *multiplier++ / dt;  // N s, by the stiffness
    double& sum = *damper++;
    if (!(element.damping > 0) || !measure(mechanism, element, state, at)) return;
    double rate = -at.given;
    for (std::size_t p = 0; p < at.points; ++p) {
      rate += at.point[p].gradient.dot(ConstMap(state + mechanism.velocity(at.point[p].point)));
    }
    for (std::size_t b = 0; b < at.bodies; ++b) {
      const BodyChange& change = at.body[b];
      at.mobility += mobility(mechanism, change.body, change.by_place, change.by_turn);
      const double* twist = state + mechanism.twist(change.body);
      const Quat rotation = quaternion(state + mechanism.pose(change.body) + 3);
      rate += change.by_place.dot(ConstMap(twist)) +
              change.by_turn.dot(rotation.conjugate() * ConstMap(twist + 3));
    }
    const double hard = element.damping * dt;  // kg
    double more = -(hard * rate + sum) / (1 + hard * at.mobility);
    if (at.pulls) more = std::min(more, -pulled - sum);
    sum += more;
    for (std::size_t p = 0; p < at.points; ++p) {
      const auto& [point, gradient] = at.point[p];
      Map(state + mechanism.velocity(point)) += more * mechanism.inverse_mass()[point] * gradient;
    }
    for (std::size_t b = 0; b < at.bodies; ++b) {
      const BodyChange& change = at.body[b];
      const auto& body = mechanism.bodies()[change.body];
      double* twist = state + mechanism.twist(change.body);
      const Quat rotation = quaternion(state + mechanism.pose(change.body) + 3);
      Map(twist) += more * body.inverse_mass * change.by_place;
      Map(twist + 3) += more * (rotation * (body.inverse_inertia * change.by_turn));
    }
  };
  for (const material::StretchElement& link : material.stretches()) slow(link);
  for (const material::BendElement& bend : material.bends()) slow(bend);
  for (const material::TwistElement& rod : material.twists()) {
    double& sum = *damper++;
    if (!(rod.damping > 0)) continue;
    material.twist_slope(rod, state, force_);
    double mobility = 0;
    for (std::uint32_t i = 0; i <= rod.links; ++i)
      mobility += mechanism.inverse_mass()[material.point_of(rod, i)] * force_[i].squaredNorm();
    const double hard = rod.damping * dt;
    const double rate = material.twist_rate(rod, state, state + mechanism.velocity(0));
    const double more = -(hard * rate + sum) / (1 + hard * mobility);
    sum += more;
    for (std::uint32_t i = 0; i <= rod.links; ++i) {
      const std::uint32_t point = material.point_of(rod, i);
      Map(state + mechanism.velocity(point)) += more * mechanism.inverse_mass()[point] * force_[i];
    }
  }
}

}  // namespace taut::methods
