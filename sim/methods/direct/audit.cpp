// The audit of a course: energy that it cannot have says that it went wrong, and where from it is
// to be followed anew.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/control.h"

namespace taut::direct {
namespace {

/// A part that gains more energy than errors of the tolerance can explain is followed anew from the
/// last audit, with the tolerance so many times as fine.
constexpr double kFiner = 0.1;

/// A loose course is audited after so many advances, which takes a tenth of its time where it is
/// one.
constexpr int kUnaudited = 4;

/// The largest error that an energy is taken to explain, as a share of the length.
constexpr double kExplained = 0.05;

}  // namespace

/// Steps to `until` or beyond; once more and finer, from the last audit on, where the energy says
/// that it went wrong.
void Course::advance_audited(World& world, double until, Counters& counters) {
  const bool fixed = control_.step > 0;
  const double tolerance = fixed ? kCoarsest * motion_->length() : control_.tolerance;
  if (closed_ && unaudited_ == 0) {
    audited_at_ = time_;
    std::ranges::copy(q_, q_audited_.begin());
    std::ranges::copy(rate_, rate_audited_.begin());
  }
  if (fixed) {
    advance_by_step(world, until, counters);
  } else {
    if (loose_) advance_loosely(world, until, tolerance, counters);
    advance_by_tolerance(world, until, tolerance, counters);
  }
  if (loose_ && ++unaudited_ < kUnaudited) return;
  unaudited_ = 0;
  if (balances(tolerance)) return;
  counters.handed_over += 1;
  time_ = audited_at_;
  q_.swap(q_audited_);
  rate_.swap(rate_audited_);
  rough_ = loose_ = only_leaps_ = fresh_ = false;
  begin();
  advance_by_tolerance(world, until, kFiner * tolerance, counters);
  known_energy_ = motion_->energy(time_, q_.data(), rate_.data()).sum();
}

/// Whether the energy is at most what it was, as far as errors of the tolerance can tell: of place
/// under the weight, and of speed, for which an error of place counts in memory(). What is lost is
/// no fault: the implicit method damps the waves that it passes over. Driven ends do work; what
/// they drive is not audited.
bool Course::balances(double tolerance) {
  if (!closed_) return true;
  const Motion::Energy energy = motion_->energy(time_, q_.data(), rate_.data());
  const double gained = energy.sum() - known_energy_;
  if (gained <= 0) return true;
  tolerance = std::min(tolerance, kExplained * motion_->length());
  const double speed = std::sqrt(2 * energy.kinetic / energy.mass);
  const double force = energy.mass * (motion_->gravity() + speed / motion_->memory());
  return !(gained > tolerance * force);
}

}  // namespace taut::direct
