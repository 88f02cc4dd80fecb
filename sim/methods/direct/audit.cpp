// The audit of a course: energy that it cannot have says that it went wrong, and that it has to be
// followed more finely.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/control.h"

namespace taut::direct {
namespace {

/// A part that gains more energy than errors of the tolerance can explain goes on with a tolerance
/// so many times as fine.
constexpr double kFiner = 0.1;

/// Below this share of the length rounding says more than the tolerance.
constexpr double kFinest = 1e-11;

/// The largest error that an energy is taken to explain, as a share of the length.
constexpr double kExplained = 0.05;

}  // namespace

/// Steps to `until` or beyond. Where the energy says that these steps went wrong, nobody has seen
/// their end yet: they are taken again, more finely, from the last state that was shown.
void Course::advance_audited(World& world, double until, Counters& counters) {
  for (;;) {
    if (fixed_) {
      advance_by_step(world, until, counters);
    } else {
      if (loose_) advance_loosely(world, until, counters);
      advance_by_tolerance(world, until, counters);
    }
    if (balances() || tolerance_ <= kFinest * motion_->length()) return;
    go_on_finer();
    counters.handed_over += 1;
  }
}

/// Keeps what store() shows, which no audit takes back. A state within the last step stands in
/// q_between_, which nothing else needs.
void Course::note_shown(double time) {
  if (!closed_) return;
  shown_at_ = time;
  if (time_ == time) {
    std::ranges::copy(q_, q_shown_.begin());
    std::ranges::copy(rate_, rate_shown_.begin());
  } else {
    q_shown_.swap(q_between_);
    rate_shown_.swap(rate_between_);
  }
}

/// Returns to the last state that was shown, never to one before it. What that has gained stays;
/// from there on the part may gain what errors of the finer tolerance explain.
void Course::go_on_finer() {
  tolerance_ = kFiner * std::min(tolerance_, kExplained * motion_->length());
  fixed_ = rough_ = loose_ = only_leaps_ = fresh_ = false;
  time_ = shown_at_;
  std::ranges::copy(q_shown_, q_.begin());
  std::ranges::copy(rate_shown_, rate_.begin());
  const double shown = motion_->energy(time_, q_.data(), rate_.data()).sum();
  known_energy_ = std::max(known_energy_, shown);
  begin();
}

/// Whether the energy is at most what it was, as far as errors of the tolerance can tell: of place
/// under the weight, and of speed, for which an error of place counts in memory(). What is lost is
/// no fault: the implicit method damps the waves that it passes over. Driven ends do work; what
/// they drive is not audited.
bool Course::balances() {
  if (!closed_) return true;
  const Motion::Energy energy = motion_->energy(time_, q_.data(), rate_.data());
  const double gained = energy.sum() - known_energy_;
  if (gained <= 0) return true;
  const double error = std::min(tolerance_, kExplained * motion_->length());
  const double speed = std::sqrt(2 * energy.kinetic / energy.mass);
  const double force = energy.mass * (motion_->gravity() + speed / motion_->memory());
  return !(gained > error * force);
}

}  // namespace taut::direct
