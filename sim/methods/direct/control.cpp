#include "sim/methods/direct/control.h"

#include <algorithm>
#include <cmath>

namespace taut::direct {
namespace {

/// The error of one step, as a share of the tolerance: errors of earlier steps grow (by about a
/// hundred in a second for a rope of 0.2 m that swings) and add up.
constexpr double kStepShare = 0.01;

constexpr double kSafety = 0.9;
constexpr double kMostGrowth = 4, kMostShrink = 0.2;
constexpr double kFirstStep = 1e-3;  // s; the error control finds the right one from there

// What a step costs, in solves of all tensions; measured.
constexpr double kCarefulCost = 15, kCheapCost = 8;
constexpr int kShortestProbeInterval = 4, kLongestProbeInterval = 64;  // steps

/// A fixed step whose error estimate exceeds this share of the net's length is done again.
constexpr double kCoarsest = 0.01;

/// The step whose error would be the one allowed, after one of h that had `error` times that where
/// `wish` was thought possible: h may be far shorter than that, to end with the frame.
double scaled_step(double h, double wish, double error, double order) {
  if (!std::isfinite(error)) return h * kMostShrink;
  const double scaled = h * std::max(kMostShrink, kSafety * std::pow(error, -1 / order));
  return std::min(scaled, std::max(kMostGrowth * h, wish));
}

}  // namespace

Course::Course(const World& world, Component component, const Control& control)
    : component_(std::move(component)), control_(control) {
  plan(world, world.time, find_plane(world, component_, world.time, Vec3::Zero()));
}

void Course::plan(const World& world, double time, const std::optional<Plane>& plane) {
  planned_at_ = time;
  net_ = std::make_unique<Net>(world, component_, plane);
  careful_ = std::make_unique<Dop853Step>(net_->size());
  cheap_ = std::make_unique<RosenbrockStep>(net_->size());
  acceleration_.assign(net_->size(), 0.0);
}

void Course::load(const World& world) {
  plan(world, world.time, find_plane(world, component_, world.time, Vec3::Zero()));
  time_ = world.time;
  net_->load(world, time_, q_, rate_);
  net_->project(time_, q_.data(), rate_.data());
  fresh_ = use_cheap_ = false;
  careful_step_ = kFirstStep;
  steps_to_probe_ = 0;
  probe_interval_ = kShortestProbeInterval;
}

void Course::advance(World& world, double until, Counters& counters) {
  net_->attach(world);
  if (control_.step > 0) {
    advance_by_step(world, until, counters);
  } else {
    advance_by_tolerance(world, until, kStepShare * control_.tolerance, counters);
  }
  net_->store(world, until, q_.data(), rate_.data());
}

void Course::refresh(Counters& counters) {
  if (fresh_) return;
  net_->acceleration(time_, q_.data(), rate_.data(), acceleration_.data());
  limit_ = Dop853Step::kStable / net_->fastest();
  counters.solves += 1;
  fresh_ = true;
}

/// The error (m) of a step of h by the integrator that use_cheap_ says.
double Course::attempt(double h, Counters& counters) {
  if (use_cheap_) {
    counters.solves += RosenbrockStep::kStages - 1;
    return cheap_->attempt(*net_, time_, h, q_.data(), rate_.data(), acceleration_.data());
  }
  counters.solves += kStages - 1;
  return careful_->attempt(*net_, time_, h, q_.data(), rate_.data(), acceleration_.data());
}

void Course::accept(double time, Counters& counters) {
  const std::vector<double>& q = use_cheap_ ? cheap_->q() : careful_->q();
  const std::vector<double>& rate = use_cheap_ ? cheap_->rate() : careful_->rate();
  std::copy(q.begin(), q.end(), q_.begin());
  std::copy(rate.begin(), rate.end(), rate_.begin());
  time_ = time;
  net_->project(time_, q_.data(), rate_.data());
  fresh_ = false;
  counters.steps += 1;
}

/// A hold has left the plane: goes on from where the last step ended, in another plane (a chain
/// that hangs still fits many) or in space.
bool Course::leave_plane(World& world) {
  const std::optional<Vec3> reason = net_->left_plane();
  if (!reason) return false;
  net_->store(world, time_, q_.data(), rate_.data());
  std::optional<Plane> plane;
  if (planned_at_ != time_) plane = find_plane(world, component_, time_, *reason);
  plan(world, time_, plane);
  net_->load(world, time_, q_, rate_);
  fresh_ = false;
  return true;
}

void Course::advance_by_tolerance(World& world, double until, double allowed, Counters& counters) {
  while (time_ < until) {
    refresh(counters);
    const double wish = use_cheap_ ? cheap_step_ : std::min(careful_step_, limit_);
    // Equal steps to the end, so that none is a sliver.
    const double left = until - time_;
    const double pieces = std::max(1.0, std::ceil(left / wish - 1e-6));
    const double h = left / pieces;
    if (!(time_ + h > time_)) throw StepTooSmall{time_};
    const double error = attempt(h, counters) / allowed;
    if (leave_plane(world)) continue;
    const bool good = error <= 1;  // false for NaN
    if (good) {
      accept(pieces > 1 ? time_ + h : until, counters);
    } else {
      counters.rejected += 1;
    }
    adapt(h, wish, error, counters);
    if (!good && use_cheap_) fresh_ = false;  // it needs the tensions of the present state
  }
}

/// Chooses the next step and its integrator from how a step of h went where `wish` was possible.
void Course::adapt(double h, double wish, double error, Counters& counters) {
  const double order = use_cheap_ ? RosenbrockStep::kErrorOrder : Dop853Step::kErrorOrder;
  const double next = scaled_step(h, wish, error, order);
  if (!use_cheap_) {
    careful_step_ = next;
    if (careful_step_ > limit_ && --steps_to_probe_ <= 0) {
      use_cheap_ = true;
      cheap_step_ = limit_;
    }
    return;
  }
  cheap_step_ = next;
  if (cheap_step_ * kCarefulCost < limit_ * kCheapCost) {
    use_cheap_ = false;
    careful_step_ = limit_;
    steps_to_probe_ = probe_interval_;
    probe_interval_ = std::min(2 * probe_interval_, kLongestProbeInterval);
    counters.handed_over += 1;
  } else if (error <= 1) {
    probe_interval_ = kShortestProbeInterval;
  }
}

/// Fixed steps: the careful integrator where it is stable, else the cheap one. A step that goes
/// astray is done again in smaller ones.
void Course::advance_by_step(World& world, double until, Counters& counters) {
  const StepTimes times(time_, until, control_.step);
  const double allowed = kCoarsest * net_->length();
  for (std::uint64_t i = 1; i <= times.count; ++i) {
    const double end = times.at(i);
    while (time_ < end) {
      refresh(counters);
      const double h = end - time_;
      use_cheap_ = h > limit_;
      const double error = attempt(h, counters);
      if (leave_plane(world)) continue;
      if (error <= allowed) {
        accept(end, counters);
        continue;
      }
      counters.rejected += 1;
      counters.handed_over += 1;
      use_cheap_ = false;
      careful_step_ = h / 2;
      advance_by_tolerance(world, end, allowed, counters);
    }
  }
}

}  // namespace taut::direct
