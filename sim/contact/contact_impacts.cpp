// Impacts that would make energy.
#include <algorithm>

#include "sim/contact/contact_motion.h"
#include "sim/contact/restitution.h"

namespace taut::contact {

/// Whether obstacles or what holds points move, and may give energy.
bool ContactMotion::is_driven() const {
  const auto moves = [](const Obstacle& obstacle) { return obstacle.path != nullptr; };
  if (std::ranges::any_of(obstacles_, moves)) return true;
  for (std::size_t p = 0; p < free_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0 && !is_carried_[p] && !free_[p].isZero(0)) return true;
  }
  return false;
}

/// J, half of the product of two motions with all masses: for one alone its kinetic energy.
double ContactMotion::energy_of(const State& state, const Motion& one, const Motion& other) const {
  double sum = 0;
  for (std::size_t p = 0; p < one.points.size(); ++p) {
    const double inverse_mass = mechanism_.inverse_mass()[p];
    if (inverse_mass > 0) sum += one.points[p].dot(other.points[p]) / inverse_mass / 2;
  }
  for (std::size_t b = 0; b < one.bodies.size(); ++b) {
    const Mechanism::FreeBody& body = mechanism_.bodies()[b];
    const Quat back = quaternion(&state[mechanism_.pose(b) + 3]).normalized().conjugate();
    const Vec3 spin = back * one.bodies[b].tail<3>();
    const Vec3 others_spin = back * other.bodies[b].tail<3>();
    sum += one.bodies[b].head<3>().dot(other.bodies[b].head<3>()) / body.inverse_mass / 2;
    sum += spin.dot(body.inertia * others_spin) / 2;
  }
  return sum;
}

/// The motion after the impact that balance() has found.
ContactMotion::Motion ContactMotion::after_impact() const {
  Motion after{free_, body_free_};
  for (std::size_t p = 0; p < free_.size(); ++p) after.points[p] += added_[p];
  for (std::size_t b = 0; b < body_free_.size(); ++b) after.bodies[b] += body_added_[b];
  return after;
}

/// Where the impact that balance() has found would make energy, it goes with the share of what is
/// thrown back that makes none, see share_thrown_back().
void ContactMotion::lower_bounces(const State& state) {
  const Motion before{free_, body_free_}, thrown = after_impact();
  ImpactEnergies energy{.before = energy_of(state, before, before),
                        .thrown = energy_of(state, thrown, thrown)};
  if (!gains_energy(energy.before, energy.thrown)) return;
  for (Bead& bead : beads_) bead.touch.least = bead.touch.normal.dot(bead.touch.surface);
  for (BodyTouch& at : body_touches_) {
    at.touch.least = at.touch.normal.dot(at.touch.surface);
    at.given.setZero();
  }
  std::ranges::fill(tension_, 0.0);
  balance(start_);
  const Motion stopped = after_impact();
  energy.stopped = energy_of(state, stopped, stopped);
  energy.mixed = energy_of(state, stopped, thrown);
  const double share = share_thrown_back(energy);
  for (std::size_t p = 0; p < added_.size(); ++p) {
    added_[p] += share * (thrown.points[p] - stopped.points[p]);
  }
  for (std::size_t b = 0; b < body_added_.size(); ++b) {
    body_added_[b] += share * (thrown.bodies[b] - stopped.bodies[b]);
  }
}

}  // namespace taut::contact
