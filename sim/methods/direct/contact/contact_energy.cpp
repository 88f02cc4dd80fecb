// The energy of a step at obstacles, where nothing is driven.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/contact/contact_step.h"

namespace taut::direct {
namespace {

using ConstMap = Eigen::Map<const Vec3>;

constexpr double kGiven = 1e-10;  // of the kinetic energy, and of lifting all by the length

Vec3 vector_at(const std::vector<double>& state, std::size_t at) {
  return ConstMap(&state[at]);
}

}  // namespace

/// Whether obstacles or what holds points move, and may give energy.
bool ContactStep::is_driven() const {
  const auto& mobile = mechanism_.inverse_mass();
  for (const Obstacle& obstacle : *obstacles_) {
    if (obstacle.path) return true;
  }
  for (std::size_t p = 0; p < mobile.size(); ++p) {
    const bool moves = !vector_at(next_, mechanism_.velocity(p)).isZero(0) ||
                       !vector_at(state_, mechanism_.velocity(p)).isZero(0);
    if (mobile[p] == 0 && !is_carried_[p] && moves) return true;
  }
  return false;
}

/// J, half of the product of the velocities of two states with the masses of what moves freely: of
/// one alone its kinetic energy. Bodies are turned as at the step's end.
double ContactStep::energy_of(const std::vector<double>& one,
                              const std::vector<double>& other) const {
  double sum = 0;
  const auto& mobile = mechanism_.inverse_mass();
  for (std::size_t p = 0; p < mobile.size(); ++p) {
    const std::size_t at = mechanism_.velocity(p);
    if (mobile[p] > 0) sum += vector_at(one, at).dot(vector_at(other, at)) / mobile[p] / 2;
  }
  for (std::size_t b = 0; b < mechanism_.bodies().size(); ++b) {
    const Mechanism::FreeBody& body = mechanism_.bodies()[b];
    const std::size_t twist = mechanism_.twist(b);
    const Quat back = quaternion(&next_[mechanism_.pose(b) + 3]).conjugate();
    const Vec3 spin = back * vector_at(one, twist + 3);
    const Vec3 others_spin = back * vector_at(other, twist + 3);
    sum += vector_at(one, twist).dot(vector_at(other, twist)) / body.inverse_mass / 2;
    sum += spin.dot(body.inertia * others_spin) / 2;
  }
  return sum;
}

/// How the energy of what moves freely changes in the step; nothing where something is driven.
ContactStep::EnergyChange ContactStep::energy_change() const {
  EnergyChange sum;
  if (is_driven()) return sum;
  const auto& mobile = mechanism_.inverse_mass();
  const auto add = [&](double heavy, const Vec3& before, const Vec3& after, double lifted) {
    sum.mass += heavy;
    sum.kinetic += heavy * after.squaredNorm() / 2;
    sum.gain += heavy * ((after.squaredNorm() - before.squaredNorm()) / 2 + lifted);
  };
  for (std::size_t p = 0; p < mobile.size(); ++p) {
    if (mobile[p] == 0) continue;
    const std::size_t at = mechanism_.velocity(p);
    add(1 / mobile[p], vector_at(state_, at), vector_at(next_, at),
        mechanism_.gravity().dot(position(state_, p) - position(next_, p)));
  }
  for (std::size_t b = 0; b < mechanism_.bodies().size(); ++b) {
    const Mechanism::FreeBody& body = mechanism_.bodies()[b];
    const std::size_t pose = mechanism_.pose(b), twist = mechanism_.twist(b);
    add(1 / body.inverse_mass, vector_at(state_, twist), vector_at(next_, twist),
        mechanism_.gravity().dot(vector_at(state_, pose) - vector_at(next_, pose)));
    const auto turning = [&](const std::vector<double>& state) {
      const Vec3 spin = quaternion(&state[pose + 3]).conjugate() * vector_at(state, twist + 3);
      return spin.dot(body.inertia * spin) / 2;
    };
    sum.kinetic += turning(next_);
    sum.gain += turning(next_) - turning(state_);
  }
  return sum;
}

/// By how much (m/s) what moves freely is too fast where nothing is driven: what touches takes
/// energy and gives none.
double ContactStep::too_fast(const EnergyChange& change) {
  if (!(change.gain > 0)) return 0;
  return change.gain / std::sqrt(2 * change.mass * (change.kinetic + change.gain));
}

/// Takes back what has been gained since the energy was least: all velocities in the same
/// proportion, so that lengths and touches still hold (Hairer, Lubich and Wanner, Geometric
/// Numerical Integration, IV.4). The energy of free bodies in flight goes up and down by itself.
void ContactStep::take_gain(const EnergyChange& change) {
  rises_ = 0;
  if (!mechanism_.bodies().empty()) return;
  rises_ = std::max(0.0, risen_ + change.gain);
  if (change.mass == 0) return;  // not known
  const double lifted = change.mass * mechanism_.gravity().norm() * length_;
  if (!(rises_ > kGiven * (change.kinetic + lifted))) return;
  const double share = std::sqrt(std::max(0.0, 1 - rises_ / change.kinetic));
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    Eigen::Map<Vec3>(&next_[mechanism_.velocity(p)]) *= share;
  }
  rises_ = 0;
}

}  // namespace taut::direct
