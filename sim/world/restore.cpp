#include "sim/world/restore.h"

#include <algorithm>
#include <cmath>

#include "sim/world/places.h"

namespace taut {
namespace {

/// Lays links of a span that nothing holds at one end in the directions that they have, each at its
/// length: from the end that is held, or so that the centre of mass stays.
void lay(Connector& connector, std::size_t first, std::size_t last) {
  std::vector<Vec3>& p = connector.position;
  const bool forth = holds(connector, first), back = !forth && holds(connector, last);
  Vec3 next = back ? p[last] : p[first], moment = Vec3::Zero();
  double mass = 0;
  const auto place = [&](std::size_t i, const Vec3& there) {
    moment += connector.particle_mass[i] * (there - p[i]);
    mass += connector.particle_mass[i];
    p[i] = there;
  };
  for (std::size_t step = 0; step < last - first; ++step) {
    const std::size_t i = back ? last - step : first + step, beyond = back ? i - 1 : i + 1;
    const Vec3 gap = p[beyond] - p[i];
    place(i, next);
    next += connector.rest[back ? beyond : i] / gap.norm() * gap;
  }
  place(back ? first : last, next);
  if (forth || back) return;
  for (std::size_t i = first; i <= last; ++i) p[i] -= moment / mass;
}

}  // namespace

/// How far off a link's squared length is, as a share, of the links from `first` to `last`.
double LinkRestorer::measure(const Connector& connector, std::size_t first, std::size_t last) {
  double worst = 0;
  for (std::size_t k = first; k < last; ++k) {
    Row& row = rows_[k];
    row.gap = connector.position[k + 1] - connector.position[k];
    row.value = (row.gap.squaredNorm() - row.squared) / 2;
    worst = std::max(worst, std::abs(row.value) / row.squared);
  }
  return worst;
}

/// Link k: (w_k + w_k+1) d.d m_k - w_k d.d' m_k-1 - w_k+1 d.d'' m_k+1 = (d.d - rest^2) / 2.
bool LinkRestorer::solve(std::size_t first, std::size_t last) {
  double before = 0, upper = 0, value = 0;  // of the link before
  for (std::size_t k = first; k < last; ++k) {
    Row& row = rows_[k];
    const double pivot =
        (row.inverse_mass + rows_[k + 1].inverse_mass) * row.gap.squaredNorm() - before * upper;
    if (!(pivot > 0)) return false;
    const double inverse = 1 / pivot;
    value = (row.value - before * value) * inverse;
    before = -rows_[k + 1].inverse_mass * row.gap.dot(rows_[k + 1].gap);
    upper = before * inverse;
    row.value = value;
    row.upper = upper;
  }
  for (std::size_t k = last - 1; k-- > first;)
    rows_[k].value -= rows_[k].upper * rows_[k + 1].value;
  return true;
}

std::size_t LinkRestorer::restore(Connector& connector, std::size_t link) {
  std::size_t first = link, last = link + 1;
  while (first > 0 && !holds(connector, first)) --first;
  while (last < connector.links() && !holds(connector, last)) ++last;
  std::vector<Vec3>& p = connector.position;
  rows_.resize(std::max(rows_.size(), connector.particles()));
  for (std::size_t i = first; i <= last; ++i) {
    const bool held = (i == first || i == last) && holds(connector, i);
    const double mass = connector.particle_mass[i];
    rows_[i].before = p[i];
    rows_[i].inverse_mass = held ? 0 : mass > 0 ? 1 / mass : 1;
    rows_[i].squared = i < last ? connector.rest[i] * connector.rest[i] : 0;
  }
  rows_[last].gap = Vec3::Zero();

  constexpr int kIterations = 20;
  constexpr double kRestored = 1e-10;
  const bool both = holds(connector, first) && holds(connector, last);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (measure(connector, first, last) <= kRestored) return last;
    if (!solve(first, last)) break;
    Vec3 before = Vec3::Zero();  // the pull of the link before
    for (std::size_t i = first; i <= last; ++i) {
      const Vec3 pull = i < last ? Vec3(rows_[i].value * rows_[i].gap) : Vec3::Zero();
      p[i] += rows_[i].inverse_mass * (pull - before);
      before = pull;
    }
    if (!both) lay(connector, first, last);  // what is left is of second order
  }
  for (std::size_t i = first; i <= last; ++i) p[i] = rows_[i].before;
  return last;
}

}  // namespace taut
