// How far a step of each integrator may go, how wrong it may be, and where it has to end.
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/methods/direct/control.h"

namespace taut::direct {
namespace {

// The error that a step may make, in tolerances: of the explicit methods so much per second (most
// of it cancels: waves go round), and at most so much; of the implicit one, which loses every wave
// only once, so much in any step.
constexpr double kCarefulRate = 15, kAdamsRate = 15, kImplicitRate = 30;  // 1/s
constexpr double kExplicitShare = 0.02, kImplicitShare = 0.008, kRoughShare = 0.04;

/// A new spacing of Adams is this share of the longest, so that it lasts.
constexpr double kNewSpacing = 0.93;

/// The waves that a step stirs up must stay this small, as turns of a link; the implicit method
/// damps them. Turns of a have the energy M g L a^2 / 2, an error e of place M g e: such waves are
/// as small as a tolerance e of so many times the square root of e/L.
constexpr double kRoughness = 0.3, kImplicitRoughness = 0.15, kRoughPerRoot = 7;

/// By how many roundings the acceleration of a link is off.
constexpr double kRoundings = 4;

/// Steps need not end with frames where the tolerance is this share of the length of all links.
constexpr double kLoose = 1e-3;

}  // namespace

/// The longest step (s) of the rung under the waves of the present state.
double Course::stable_step(Rung rung) const {
  if (rung == implicit) return std::numeric_limits<double>::infinity();
  const double reach = rung == careful ? Dop853Step::kStable : AdamsStep::kStable;
  return reach / fastest_;
}

/// The error (m) that a step of h may make.
double Course::allowed_error(Rung rung, double h) const {
  const double shortest = motion_->shortest();
  if (rung == implicit) {
    const double share = std::min(kImplicitRate * h, rough_ ? kRoughShare : kImplicitShare);
    return std::min(share * tolerance_, kImplicitRoughness * shortest);
  }
  const double rate = rung == careful ? kCarefulRate : kAdamsRate;
  const double share = std::min(rate * h, kExplicitShare);
  // No shorter step would mend what the last digit of each direction does under the tensions.
  constexpr double kDigit = std::numeric_limits<double>::epsilon() / 2;
  const double rounding = kRoundings * kDigit * fastest_ * fastest_ * motion_->shift_bound(1);
  const double rough =
      std::min(kRoughness, kRoughPerRoot * std::sqrt(tolerance_ / motion_->length()));
  return share * std::min(tolerance_, rough * shortest) + h * motion_->memory() * rounding;
}

/// Whether the rung's steps end where a state is asked for. Careful ones are too long to be
/// interpolated but roughly; of others what is interpolated is good enough for loose tolerances
/// alone, since an intervention may go on from there.
bool Course::lands(Rung rung) const {
  if (rough_) return false;
  return rung == careful || control_.step > 0 || tolerance_ < kLoose * motion_->length();
}

/// The next step of the rung, which can do `wish`: one of equal ones to `until`, so that none is a
/// sliver, where it has to end there. Adams keeps his spacing where that is near enough.
double Course::length_of_step(double until, double wish) const {
  const double left = until - time_;
  const auto share = [&](double most) {
    return lands(rung_) ? left / std::max(1.0, std::ceil(left / most - 1e-6)) : most;
  };
  if (rung_ != adams) return share(wish);
  const double h = adams_.spacing();
  const bool fits = !lands(adams) || std::abs(std::round(left / h) * h - left) <= 1e-9 * h;
  if (fits && h <= wish && h >= kLeastSpacing * wish) return h;
  return share(h > wish ? kNewSpacing * wish : wish);
}

/// Where a step of h ends that is one of equal ones to `until`, without rounding.
double Course::end_of_step(double until, double h) const {
  return lands(rung_) && until - time_ < 1.5 * h ? until : time_ + h;
}

/// Where the careful step ends from which Adams's of h begin: as long as three of them, but never
/// beyond `until`, since it is too long to be interpolated.
double Course::end_of_start(double until, double h) const {
  return 3 * h < (1 - 1e-9) * (until - time_) ? time_ + 3 * h : until;
}

}  // namespace taut::direct
