// The stiffest of what stretches, bends and twists, which limits explicit steps.
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "sim/material/forces.h"

namespace taut::material {

// Of each element the matrix is stiffness d d^T, d how it changes with its points along the way in
// which it does: 1, -1 for a stretch; 1/l0, -(1/l0 + 1/l1), 1/l1 for a bend.
MaterialForces::HighestMode MaterialForces::highest_mode(
    const std::vector<double>& inverse_mass) const {
  std::vector<double> stiff(inverse_mass.size()), damped(inverse_mass.size());  // sums of rows
  const auto add = [&](double stiffness, double damping,
                       std::initializer_list<std::uint32_t> points,
                       std::initializer_list<double> changes) {
    double sum = 0;
    for (const double change : changes) sum += change;
    auto change = changes.begin();
    for (const std::uint32_t p : points) {
      stiff[p] += stiffness * *change * sum;
      damped[p] += damping * *change++ * sum;
    }
  };
  for (const StretchElement& link : stretches_) {
    add(link.stiffness, link.damping, {link.a, link.b}, {1, 1});
  }
  for (std::size_t i = 0; i < bends_.size(); ++i) {
    const BendElement& bend = bends_[i];
    const double l0 = bend.clamped_before() ? 0 : 1 / lengths_[i].before;
    const double l1 = bend.clamped_behind() ? 0 : 1 / lengths_[i].behind;
    add(bend.stiffness, bend.damping, {bend.a, bend.b, bend.c}, {l0, l0 + l1, l1});
  }
  // Of twist what the moment bends aside, at most (moment / 2) (e0^2 + e1^2) / l^2 where two links
  // meet, e how far their ends part across; and stiffness d d^T, d at most 1/l of each link, where
  // neighbours meet at one radian.
  for (const TwistElement& rod : twists_) {
    const double moment = rod.stiffness * (rod.most + std::abs(rod.since) + 2 * std::numbers::pi);
    double sum = 0;
    for (std::uint32_t k = 0; k < rod.links; ++k) sum += 2 / rest_[rod.first + k];
    for (std::uint32_t k = 0; k < rod.links; ++k) {
      const std::uint32_t a = point_of(rod, k), b = point_of(rod, k + 1);
      const double change = 1 / rest_[rod.first + k];
      add(moment, 0, {a, b}, {change, change});
      for (const std::uint32_t p : {a, b}) {
        stiff[p] += rod.stiffness * change * sum;
        damped[p] += rod.damping * change * sum;
      }
    }
  }
  // Where 4/h^2 - 2c/h - k, Gershgorin's bound of a particle's row, is above zero for each, a step
  // of h is stable: the particle with the shortest step counts, w^2 = k and c = 2 z w.
  HighestMode found;
  double most = 0;
  for (std::size_t p = 0; p < stiff.size(); ++p) {
    const double k = inverse_mass[p] * stiff[p], half = inverse_mass[p] * damped[p] / 2;
    const double rate = std::sqrt(k + half * half) + half;
    if (!(rate > most)) continue;
    most = rate;
    found.frequency = std::sqrt(k);
    found.damping_ratio = k > 0 ? half / found.frequency : 0;
    found.damping = 2 * half;
  }
  return found;
}

}  // namespace taut::material
