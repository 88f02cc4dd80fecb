#include "sim/study/beside.h"

#include <algorithm>
#include <cmath>

#include "sim/measure.h"

namespace taut {
namespace {

/// The larger one; keeps what is no number, as if it were larger than all.
void raise(double& largest, double value) {
  if (!(value <= largest)) largest = std::isfinite(value) ? value : INFINITY;
}

}  // namespace

Beside::Beside(const Exact& exact, const World& world, const Timeline& timeline,
               const Candidate& candidate, const Distance& distance)
    : exact_(exact),
      distance_(distance),
      simulation_(world, make_method(candidate.method, candidate.settings), timeline),
      marks_(world, simulation_.state()),
      balance_(timeline) {}

bool Beside::next() {
  const std::vector<double>& times = exact_.problem.times;
  if (frame_ == times.size()) return false;
  const std::size_t k = frame_++;
  simulation_.advance_to(times[k]);
  const std::vector<Vec3> points = marks_.places(exact_.marks, simulation_.state());
  const double energy = exact_.goes_on() ? balance_.next(simulation_.world()) : 0;
  if (k < exact_.known) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      raise(error_, distance_(points[i], exact_.points[k][i], times[k]));
    }
  } else {
    energy_.add(energy - exact_.energy[k]);
    raise(stretch_, stretch_max(simulation_.world()));
  }
  if (k + 1 >= exact_.known) speeds_.add(points, k > 0 ? times[k] - times[k - 1] : 1);
  return true;
}

Difference Beside::later() const {
  const bool over = frame_ == exact_.problem.times.size();
  Difference later{.stretch = stretch_};
  if (exact_.energy_scale > 0 && (exact_.balanced || over)) {
    later.energy = (exact_.balanced ? energy_.largest() : energy_.of_means()) / exact_.energy_scale;
  }
  if (over) {
    later.speeds = distribution_distance(speeds_.sorted(), exact_.speeds, exact_.same_speed);
  }
  return later;
}

double Beside::work() const {
  return simulation_.method().counters().work;
}

}  // namespace taut
