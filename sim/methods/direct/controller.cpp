#include "sim/methods/direct/controller.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace taut::direct {
namespace {

constexpr std::size_t index(Scheme scheme) {
  return static_cast<std::size_t>(scheme);
}

}  // namespace

double Controller::allowed(Scheme scheme, double h, double frequency) const {
  // No shorter step would mend what the last digit of each direction does under the tensions.
  constexpr double kDigit = std::numeric_limits<double>::epsilon();
  const double rounding = kDigit * frequency * frequency * component_.length * memory() * h;
  if (scheme != Scheme::dop853) return constants_.share * options_.tolerance + rounding;
  const double rough = constants_.roughness * component_.shortest;
  return constants_.rate * h * std::min(options_.tolerance, rough) + rounding;
}

void Controller::begin(const Component& component, double frequency, double first_step) {
  component_ = component;
  const double h = std::min(first_step, constants_.stable[1] / frequency);
  step_ = {h, h, h};
  scheme_ = Scheme::dop853;
  refused_ = 0;
}

Step Controller::choose(double time, double until, double frequency) {
  const double left = until - time;
  longest_shown_ = std::max(left, longest_shown_ * 0.999);
  const std::size_t s = index(scheme_);
  double h = std::min(step_[s], longest());
  if (scheme_ != Scheme::bdf) h = std::min(h, constants_.stable[s] / frequency);
  if (options_.step > 0) h = std::min(options_.step, constants_.stable[s] / frequency);
  double end = time + h;
  if (scheme_ == Scheme::dop853) {  // ends with what is shown, in equal steps
    const double parts = std::max(1.0, std::ceil(left / h - 1e-6));
    h = left / parts;
    end = parts == 1 ? until : time + h;
  }
  return {scheme_, h, end, allowed(scheme_, h, frequency)};
}

bool Controller::accept(const Step& step, const Outcome& outcome) {
  if (options_.step > 0) return std::isfinite(outcome.error);
  const std::size_t s = index(step.scheme);
  const bool runge_kutta = step.scheme == Scheme::dop853;
  double excess = outcome.error / step.allowed;
  if (!runge_kutta) {
    const double off = outcome.excess / constants_.most_excess;
    excess = std::max(excess, off * off);
  }
  if (step.scheme == Scheme::verlet && !(outcome.frequency * step.h < 1.9)) {
    excess = 2 * constants_.refused;  // it was not stable
  }
  // Errors as a share of what is allowed grow with the step's power 7, or 2.
  const double power = runge_kutta ? -1.0 / 7 : -0.5, most = runge_kutta ? 4 : 1.5;
  const double scale =
      std::isfinite(excess) ? constants_.safety * std::pow(excess + 1e-12, power) : 0.2;
  step_[s] = step.h * std::clamp(scale, 0.2, most);
  const bool good = excess <= (runge_kutta ? 1 : constants_.refused);
  refused_ = good ? 0 : refused_ + 1;
  if (good) {
    choose_scheme(step, outcome);
  } else if (!runge_kutta && refused_ > 2) {
    change_to(Scheme::dop853, step_[s]);
  }
  return good;
}

void Controller::change_to(Scheme scheme, double h) {
  scheme_ = scheme;
  step_[index(scheme)] = h;
}

/// The scheme whose steps get furthest for their cost, by what the last step tells of each.
void Controller::choose_scheme(const Step& step, const Outcome& outcome) {
  if (!component_.only_bodies_free) return;
  const auto& cost = constants_.cost;
  const double limit = constants_.stable[1] / outcome.frequency;
  const double careful_limit = std::min(constants_.stable[0] / outcome.frequency, longest_shown_);
  if (scheme_ == Scheme::dop853) {
    const double most = limit * std::sqrt(allowed(Scheme::verlet, limit, outcome.frequency) /
                                          std::max(outcome.bent, 1e-300));
    const double speed = step.h / cost[0], by_verlet = std::min({most, limit, longest()}) / cost[1];
    if (by_verlet > constants_.worthwhile * speed) change_to(Scheme::verlet, std::min(most, limit));
    return;
  }
  const double h = step_[index(scheme_)];
  if (scheme_ == Scheme::verlet) {
    if (constants_.worthwhile * std::min(h, limit) / cost[1] < careful_limit / cost[0]) {
      change_to(Scheme::dop853, careful_limit);
    } else if (h > constants_.worthwhile * 2 * cost[2] / cost[1] * limit) {
      change_to(Scheme::bdf, h / 2);
    }
  } else if (std::min(h, longest()) / cost[2] < limit / cost[1]) {
    change_to(Scheme::dop853, std::min(careful_limit, 4 * limit));
  }
}

}  // namespace taut::direct
