// Friction of rope that passes pulleys: how much larger one tension is than the other.
#include <algorithm>
#include <cmath>

#include "sim/links/mechanism.h"

namespace taut {

/// The rope before the pulley by itself, as seen from there, and the ratio of tensions.
void Mechanism::measure_friction(Passing& pulley, const double* state) {
  const Winched &from = winches_[pulley.end[0].winched], &to = winches_[pulley.end[1].winched];
  const std::size_t last = from.winch->rest.size(), eye = from.first_point + last;
  const auto vector = [&](std::size_t at) { return Vec3(Eigen::Map<const Vec3>(state + at)); };
  const double speed = from.last.rate, turning = from.winch->density * speed * speed;
  pulley.before =
      paying_force(from, 1, state, point_acceleration_,
                   {vector(position(eye)), vector(velocity(eye)), point_acceleration_[eye]}) -
      turning / 2;
  const Vec3 &arrives = direction_[from.first_row + last - 1], &leaves = direction_[to.first_row];
  const double turn = std::atan2(arrives.cross(leaves).norm(), arrives.dot(leaves));
  const double drag = pulley.bearing * std::sin(turn / 2);
  pulley.ratio = std::exp(pulley.friction * turn) * (1 + drag) / (1 - drag);
}

/// The pulleys' equations under friction: where rope stays, its acceleration is zero.
void Mechanism::use_friction() {
  for (std::size_t p = 0; p < pulleys(); ++p) {
    const Passing& pulley = pulleys_[p];
    auto row = passing_inertia_.row(static_cast<Eigen::Index>(p));
    if (pulley.slip == Slip::stick) {
      row.setZero();
      row[static_cast<Eigen::Index>(p)] = 1;
    } else if (pulley.excess() != 0) {
      row += pulley.excess() * pulley.before_inertia.transpose();
    }
  }
  for (Coupling& coupling : couplings_) {
    const Passing& pulley = pulleys_[coupling.pulley];
    if (pulley.slip == Slip::stick) coupling.drive = 0;
    if (pulley.excess() != 0) coupling.drive -= pulley.excess() * coupling.before;
  }
}

Mechanism::Pull Mechanism::pull_at(std::size_t pulley, const double* tension) const {
  const Passing& at = pulleys_[pulley];
  const Eigen::Map<const Eigen::VectorXd> hastens(tension + rows_.size(),
                                                  static_cast<Eigen::Index>(pulleys()));
  Pull pull{at.before + at.before_inertia.dot(hastens), 0, at.ratio};
  double drive = at.free_force;
  for (const Coupling& coupling : couplings_) {
    if (coupling.pulley != pulley) continue;
    pull.before += coupling.before * tension[coupling.row];
    drive -= coupling.value * tension[coupling.row];
  }
  pull.behind = pull.before + drive - at.inertia_of_all.dot(hastens);
  return pull;
}

}  // namespace taut
