#include "sim/methods/direct/controller.h"

#include <algorithm>
#include <cmath>

#include "sim/methods/direct/constants.h"
#include "sim/motion/stop.h"

namespace taut::direct {

double StepOptions::asked(double length) const {
  return step > 0 ? kConstants.coarsest * length : tolerance;
}

bool StallWatch::count(double time) {
  if (time - since_ > kConstants.brief) start(time);
  return ++steps_ <= kConstants.most_steps;
}

double suited_step(double h, double error, double limit, double order) {
  return h * (kConstants.safety * std::pow(limit / error, 1 / order));
}

void Controller::follow(Stepping& stepper, double until, Counters& counters) {
  watch_.start(time_);
  const bool fixed = options_.step > 0;
  if (step_ == 0) step_ = fixed ? options_.step : stepper.first_step();
  while (time_ < until) {
    const double longest = stepper.longest_step(time_);
    double event = kNever;  // s, from here
    for (bool taken = false; !taken;) {
      check_stop();
      const double wish = std::min(step_, longest), left = until - time_;
      const double parts = std::max(1.0, std::ceil(left / wish * (1 - 1e-9)));
      const bool lands = stepper.lands(left, wish);
      double h = std::min(event, lands ? left / parts : wish);
      if (fixed && !lands) h = std::min(h, to_multiple());
      const Attempt attempt = stepper.attempt(time_, h, until);
      ++counters.steps;
      if (attempt.event < kNever) {
        event = attempt.event;
        ++counters.rejected;
        continue;
      }
      taken = attempt.solved && attempt.error <= attempt.limit;  // false for NaN
      const double suited = suited_step(h, attempt.error, attempt.limit, stepper.order());
      if (!taken) {
        ++counters.rejected;
        const bool tells = attempt.solved && suited > 0;  // false for NaN
        step_ = tells ? std::clamp(suited, 0.1 * h, 0.9 * h) : 0.25 * h;
        if (step_ < kConstants.shortest) stepper.give_up(time_);
        continue;
      }
      before_ = time_;
      time_ = lands && h == left ? until : time_ + h;
      stepper.accept(time_);
      if (!watch_.count(time_) && !(fixed && h == options_.step)) stepper.give_up(time_);
      learn(h, attempt.may_grow ? suited : std::min(suited, h));
      step_ = std::max(step_, attempt.least);
    }
  }
}

/// s, to the next multiple of a fixed step: so steps end at the same times whatever is asked for.
double Controller::to_multiple() const {
  constexpr double kSliver = 1e-6;
  return (std::floor(time_ / options_.step + kSliver) + 1) * options_.step - time_;
}

/// Chooses the next step after one of h that was taken.
void Controller::learn(double h, double suited) {
  const double next = std::min(suited, h * kConstants.most_change);
  if (options_.step > 0) {  // one that was refused is done in shorter ones
    step_ = std::min(options_.step, std::max(step_, next));
  } else if (suited < h || next > step_) {
    // One that was cut to end at a time says nothing against the longer one.
    step_ = next;
  }
}

}  // namespace taut::direct
