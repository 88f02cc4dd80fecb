// How far a step of each scheme may go, how wrong it may be, and where it has to end.
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/methods/direct/integrator.h"

namespace taut::direct {

/// How long it takes the quickest link to turn by kConstants.turn (s).
double Integrator::first_step() const {
  double speed = 0, gain = 0;  // 1/s, 1/s^2
  for (std::size_t i = 0; i < q_.size(); ++i) {
    speed = std::max(speed, std::abs(rate_[i]));
    gain = std::max(gain, std::abs(acceleration_[i]));
  }
  const double turn = kConstants.turn;
  const double turned = 2 * turn / (speed + std::sqrt(speed * speed + 2 * gain * turn));
  return std::min(turned, longest_);
}

/// Whether the last attempt of the scheme, of h, changes no direction by a rounding: then no
/// shorter one errs by less.
bool Integrator::is_lost(Scheme scheme, double h) const {
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  const double* q = scheme == dop853 ? dop853_.q() : rosenbrock_.q();
  const double* rate = scheme == dop853 ? dop853_.rate() : rosenbrock_.rate();
  for (std::size_t i = 0; i < q_.size(); ++i) {
    const double change = std::abs(q[i] - q_[i]) + h * std::abs(rate[i] - rate_[i]);
    if (!(change < kRounding)) return false;
  }
  return true;
}

/// The longest step (s) of the scheme under the waves of the present state.
double Integrator::stable_step(Scheme scheme) const {
  if (scheme == rosenbrock) return std::numeric_limits<double>::infinity();
  return (scheme == dop853 ? Dop853Step::kStable : AdamsStep::kStable) / waves_ / options_.finer;
}

/// The error (m) that a run may make.
double Integrator::asked_error() const {
  const double length = system_.length();
  if (!(length > 0)) return options_.tolerance;  // a body alone
  if (options_.step > 0) return kConstants.coarsest * length;
  return std::min(options_.tolerance, kConstants.largest * length);
}

/// The error (m) that a step of h of the scheme may make.
double Integrator::allowed_error(Scheme scheme, double h) const {
  const double share = std::min(kConstants.rate * options_.finer * h, kConstants.share);
  const double rough = kConstants.turn * system_.shortest() / kConstants.share;
  // No shorter step would mend what the last digit of each direction does under the tensions.
  constexpr double kDigit = std::numeric_limits<double>::epsilon() / 2;
  const double rounding =
      kConstants.roundings * kDigit * waves_ * waves_ * system_.displacement_bound(1);
  return share * std::min(asked_error(), rough) / larger_[scheme] +
         h * system_.velocity_time() * rounding;
}

/// The error of a step of h of the scheme, as a share of the one that it may make. Waves are passed
/// over only where they are as quick at the step's end: damping under tensions that are gone says
/// nothing of an error.
double Integrator::share_of_allowed(Scheme scheme, double h, const StepError& error) const {
  const bool lasting = h * system_.wave_frequency() > Dop853Step::kStable;
  const double followed = (lasting ? error.followed : error.all) / allowed_error(scheme, h);
  const double once = kConstants.passed_over * asked_error() / larger_[scheme];
  return std::max(followed, error.passed_over / once);
}

/// Whether the scheme's steps end where a state is asked for. DOP853's are too long to be
/// interpolated but roughly; of others what is interpolated is good enough for loose tolerances
/// alone, since an intervention may go on from there.
bool Integrator::lands(Scheme scheme) const {
  return scheme == dop853 || options_.step > 0 ||
         options_.tolerance < kConstants.interpolated * system_.length();
}

/// The next step of the scheme, which can do `wish`: one of equal ones to `until`, so that none is
/// a sliver, where it has to end there. Adams keeps its spacing where that is near enough.
double Integrator::length_of_step(double until, double wish) const {
  const double left = until - time_;
  const auto share = [&](double most) {
    return lands(scheme_) ? left / std::max(1.0, std::ceil(left / most - 1e-6)) : most;
  };
  if (scheme_ != adams) return share(wish);
  const double h = adams_.spacing();
  const bool fits = !lands(adams) || std::abs(std::round(left / h) * h - left) <= 1e-9 * h;
  if (fits && h <= wish && h >= AdamsStep::kLeastSpacing * wish) return h;
  return share(h > wish ? kConstants.safety * wish : wish);
}

/// Where a step of h ends that is one of equal ones to `until`, without rounding.
double Integrator::end_of_step(double until, double h) const {
  return lands(scheme_) && until - time_ < 1.5 * h ? until : time_ + h;
}

/// Where DOP853's step ends from which Adams's of h begin: as long as three of them, but never
/// beyond `until`, since it is too long to be interpolated.
double Integrator::end_of_start(double until, double h) const {
  return 3 * h < (1 - 1e-9) * (until - time_) ? time_ + 3 * h : until;
}

}  // namespace taut::direct
