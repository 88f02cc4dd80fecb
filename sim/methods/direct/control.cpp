#include "sim/methods/direct/control.h"

#include <algorithm>
#include <cmath>

namespace taut::direct {
namespace {

/// The error of one step, as a share of the tolerance. Errors of earlier steps grow (by about a
/// hundred in a second for a rope of 0.2 m that swings) and add up; an eighth-order step that is a
/// hundred times more accurate is less than twice as dear.
constexpr double kStepShare = 0.01;

constexpr double kSafety = 0.9;
constexpr double kMostGrowth = 4, kMostShrink = 0.2;
constexpr double kFirstStep = 1e-3;  // s; the error control finds the right one from there

}  // namespace

Course::Course(const World& world, Component component, const Control& control)
    : net_(world, std::move(component)),
      control_(control),
      careful_(net_.size()),
      acceleration_(net_.size()) {}

void Course::load(const World& world) {
  net_.load(world, q_, rate_);
  time_ = world.time;
  net_.project(time_, q_.data(), rate_.data());
  next_step_ = 0;
}

void Course::advance(World& world, double until, Counters& counters) {
  net_.attach(world);
  if (control_.step > 0) {
    advance_fixed(until, counters);
  } else {
    advance_to(until, counters);
  }
  net_.store(world, until, q_.data(), rate_.data());
}

void Course::accept(double time) {
  std::copy(careful_.q().begin(), careful_.q().end(), q_.begin());
  std::copy(careful_.rate().begin(), careful_.rate().end(), rate_.begin());
  time_ = time;
  net_.project(time_, q_.data(), rate_.data());
}

void Course::advance_fixed(double until, Counters& counters) {
  const StepTimes times(time_, until, control_.step);
  for (std::uint64_t i = 0; i < times.count; ++i) {
    net_.acceleration(time_, q_.data(), rate_.data(), acceleration_.data());
    const double end = times.at(i + 1);
    careful_.attempt(net_, time_, end - time_, q_.data(), rate_.data(), acceleration_.data());
    accept(end);
    counters.steps += 1;
    counters.solves += kStages;
  }
}

void Course::advance_to(double until, Counters& counters) {
  if (!(next_step_ > 0)) next_step_ = kFirstStep;
  const double allowed = kStepShare * control_.tolerance;
  bool fresh = false;
  while (time_ < until) {
    // Equal steps to the end, so that none is a sliver.
    const double left = until - time_;
    const double pieces = std::max(1.0, std::ceil(left / next_step_ - 1e-6));
    const double h = left / pieces;
    if (!(time_ + h > time_)) throw StepTooSmall{time_};
    if (!fresh) {
      net_.acceleration(time_, q_.data(), rate_.data(), acceleration_.data());
      counters.solves += 1;
      fresh = true;
    }
    const double error =
        careful_.attempt(net_, time_, h, q_.data(), rate_.data(), acceleration_.data()) / allowed;
    counters.solves += kStages - 1;
    const bool good = error <= 1;  // false for NaN
    const double wish =
        std::isfinite(error)
            ? h * std::clamp(kSafety * std::pow(error, -1 / Dop853Step::kErrorOrder), kMostShrink,
                             kMostGrowth)
            : h * kMostShrink;
    if (good) {
      accept(pieces > 1 ? time_ + h : until);
      counters.steps += 1;
      fresh = false;
    } else {
      counters.rejected += 1;
    }
    next_step_ = good && pieces == 1 ? std::max(wish, std::min(next_step_, kMostGrowth * h)) : wish;
  }
}

}  // namespace taut::direct
