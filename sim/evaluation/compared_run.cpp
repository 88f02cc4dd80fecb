#include "sim/evaluation/compared_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/measure/measure.h"

namespace taut::study {
namespace {

/// The larger one; keeps what is no number, as if it were larger than all.
void raise(double& largest, double value) {
  if (!(value <= largest)) largest = std::isfinite(value) ? value : INFINITY;
}

}  // namespace

ComparedRun::ComparedRun(const ReferenceSolution& reference, const World& world,
                         const Timeline& timeline, const MethodChoice& candidate,
                         const Distance& distance)
    : reference_(reference),
      distance_(distance),
      simulation_(world, make_method(candidate.name, candidate.settings), timeline),
      sample_points_(world, simulation_.state()),
      balance_(timeline) {}

bool ComparedRun::next() {
  const std::vector<double>& times = reference_.problem.times;
  if (frame_ == times.size()) return false;
  const std::size_t k = frame_++;
  simulation_.advance_to(times[k]);
  const std::vector<Vec3> points =
      sample_points_.places(reference_.sample_points, simulation_.state());
  const double energy =
      reference_.goes_on() ? balance_.next(std::as_const(simulation_).world()) : 0;
  if (k < reference_.known) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      raise(error_, distance_(points[i], reference_.points[k][i], times[k]));
    }
  } else {
    energy_.add(energy - reference_.energy[k]);
    raise(stretch_, stretch_max(std::as_const(simulation_).world()));
  }
  if (k + 1 >= reference_.known) speeds_.add(points, k > 0 ? times[k] - times[k - 1] : 1);
  return true;
}

Difference ComparedRun::later() const {
  const bool over = frame_ == reference_.problem.times.size();
  Difference later{.stretch = stretch_};
  if (reference_.energy_scale > 0 && (reference_.balanced || over)) {
    later.energy =
        (reference_.balanced ? energy_.largest() : energy_.of_means()) / reference_.energy_scale;
  }
  if (over) {
    later.speeds =
        distribution_distance(speeds_.sorted(), reference_.speeds, reference_.same_speed);
  }
  return later;
}

double ComparedRun::cycles() const {
  return simulation_.method().counters().cycles;
}

}  // namespace taut::study
