#include "sim/restore.h"

#include <algorithm>
#include <cmath>

#include "sim/places.h"

namespace taut {

void LinkRestorer::restore(Connector& connector, std::size_t link) {
  std::size_t first = link, last = link + 1;
  while (first > 0 && !holds(connector, first)) --first;
  while (last < connector.links() && !holds(connector, last)) ++last;
  const auto ease = [&](std::size_t i) {
    if ((i == first || i == last) && holds(connector, i)) return 0.0;
    return connector.particle_mass[i] > 0 ? 1 / connector.particle_mass[i] : 1.0;
  };
  const std::vector<double>& rest = connector.rest;
  std::vector<Vec3>& p = connector.position;
  rows_.resize(std::max(rows_.size(), connector.links() + 1));
  for (std::size_t i = first; i <= last; ++i) rows_[i].before = p[i];

  constexpr int kIterations = 20;
  constexpr double kRestored = 1e-10;
  double worst = 1;
  for (int iteration = 0; iteration < kIterations && worst > kRestored; ++iteration) {
    worst = 0;
    // Link k: (w_k + w_k+1) d.d m_k - w_k d.d' m_k-1 - w_k+1 d.d'' m_k+1 = (d.d - rest^2) / 2.
    for (std::size_t k = first; k < last; ++k) {
      const Vec3 d = p[k + 1] - p[k];
      const double excess = (d.squaredNorm() - rest[k] * rest[k]) / 2;
      worst = std::max(worst, std::abs(excess) / (rest[k] * rest[k]));
      double pivot = (ease(k) + ease(k + 1)) * d.squaredNorm();
      double value = excess;
      if (k > first) {
        const double lower = -ease(k) * d.dot(p[k] - p[k - 1]);
        pivot -= lower * rows_[k - 1].upper;
        value -= lower * rows_[k - 1].value;
      }
      if (!(pivot > 0)) {
        worst = INFINITY;
        break;
      }
      const double upper = k + 1 < last ? -ease(k + 1) * d.dot(p[k + 2] - p[k + 1]) : 0;
      rows_[k].upper = upper / pivot;
      rows_[k].value = value / pivot;
    }
    if (!std::isfinite(worst)) break;
    Vec3 after = Vec3::Zero();  // the pull of the link behind
    for (std::size_t k = last; k-- > first;) {
      if (k + 1 < last) rows_[k].value -= rows_[k].upper * rows_[k + 1].value;
      const Vec3 pull = rows_[k].value * (p[k + 1] - p[k]);
      p[k + 1] += ease(k + 1) * (after - pull);
      after = pull;
    }
    p[first] += ease(first) * after;
  }
  if (worst <= kRestored) return;
  for (std::size_t i = first; i <= last; ++i) p[i] = rows_[i].before;
}

}  // namespace taut
