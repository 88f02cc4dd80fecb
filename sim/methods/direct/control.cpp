#include "sim/methods/direct/control.h"

#include <algorithm>
#include <cmath>

namespace taut::direct {
namespace {

constexpr double kSafety = 0.9;
constexpr double kMostGrowth = 4, kMostShrink = 0.2, kLostShrink = 0.4;
constexpr double kFirstStep = 1e-3;  // s; the error control finds the right one from there
/// The first step of a rough course turns a link by about so much (rad), and is at most
/// this share of the longest.
constexpr double kFirstTurn = 0.3, kLongestFirst = 0.25;

// What a step costs, in accelerations; measured.
constexpr double kCarefulCost = 12.5, kAdamsCost = 1.6, kImplicitCost = 6.5;
/// Adams's steps are worth a try where the error allows careful ones of this share of what the
/// waves do.
constexpr double kHeldUp = 0.25;
/// Of the steps that the waves allow Adams's, what the error is likely to.
constexpr double kLikely = 0.8;
constexpr int kShortestRest = 4, kLongestRest = 1024;  // careful steps

// Adams keeps its spacing while the error is below the one and, where it is below the other, while
// the waves would not let the step grow by a third.
constexpr double kMuch = 0.8, kLittle = 0.15;

/// Nothing that the implicit method passes over is worth a careful step where the tolerance is this
/// share of the length of all links.
constexpr double kRough = 0.03;

/// From here on BDF2 or leaps take all steps.
constexpr double kLoose = 0.06;

/// From here on leaps take all steps where links push, or no wave comes near to stiffening them.
constexpr double kLeapt = 0.004;

/// A rough course hands over where that makes it so many times as fast.
constexpr double kWorthwhile = 3;

/// Steps that no frame ends must not pass over what a driven end does meanwhile, nor go far beyond
/// the time that is asked for.
constexpr double kLongest = 0.25, kLongestDriven = 1.0 / 30;  // s

bool driven(const World& world, const Component& component) {
  for (const SpanRange& span : component.spans) {
    for (const std::size_t particle : {span.first, span.last}) {
      const Hold* hold = hold_at(world.connectors[span.connector], particle);
      if (hold && is_prescribed(world, hold->to) && !rests(hold->to, world.time)) return true;
    }
  }
  return false;
}

/// The step whose error would be the one allowed, after one of h that had `error` times that.
double scaled_step(double h, double error, double order) {
  if (!std::isfinite(error)) return h * kLostShrink;
  return h * std::max(kMostShrink, kSafety * std::pow(error, -1 / order));
}

}  // namespace

void Course::reserve(std::size_t links, std::size_t ends, std::size_t bodies) {
  planes_.reserve(links);
  chain_.reserve(links);
  net_.reserve(links, ends, bodies);
  const std::size_t size = 3 * (links + kLanes) + 4 * ends + 2 * Links::kPad;
  arena_.reserve(kArrays, size);
}

void Course::plan(const World& world, double time, const std::optional<Plane>& plane) {
  planned_at_ = time;
  if (plane && PlanarChain::fits(world, component_)) {
    chain_.rebuild(world, component_, *plane);
    motion_ = &chain_;
  } else {
    net_.rebuild(world, component_, plane);
    motion_ = &net_;
  }
  arena_.reset(kArrays, motion_->size());
  for (Slice* slice : {&q_, &rate_, &acceleration_, &q_before_, &rate_before_, &q_between_,
                       &rate_between_, &q_shown_, &rate_shown_}) {
    *slice = arena_.make();
  }
  careful_.make_arrays(arena_);
  adams_.make_arrays(arena_);
  implicit_.make_arrays(arena_);
  backward_.make_arrays(arena_);
  leap_.make_arrays(arena_);
  closed_ = !driven(world, component_);
  longest_ = closed_ ? kLongest : kLongestDriven;
  cost_ = {kCarefulCost, kAdamsCost, kImplicitCost};
  for (double& cost : cost_) cost += motion_->projection_cost();
}

void Course::load(const World& world) {
  plan(world, world.time, planes_.find(world, component_, world.time, Vec3::Zero()));
  time_ = world.time;
  motion_->load(world, time_, q_.data(), rate_.data());
  motion_->project(time_, q_.data(), rate_.data());
  fixed_ = control_.step > 0;
  tolerance_ = fixed_ ? kCoarsest * motion_->length() : control_.tolerance;
  const double share = fixed_ ? 0 : tolerance_ / motion_->length();
  rough_ = share >= kRough;
  // Until it is known what its links do.
  only_leaps_ = share >= kLeapt && share < kLoose && closed_ && motion_->leaps();
  loose_ = share >= kLoose || only_leaps_;
  fresh_ = false;
  note_shown(time_);
  begin();
  if (closed_) known_energy_ = motion_->energy(time_, q_.data(), rate_.data()).sum();
}

/// Knows nothing but the state.
void Course::begin() {
  rung_ = careful;
  step_ = rough_ || loose_ ? 0 : kFirstStep;
  looks_back_ = false;
  reach_ = Dop853Step::kStable;
  rests_.fill({0, kShortestRest});
}

/// How long it takes a link to turn by `turn` (rad), but at most a share of the longest step (s).
double Course::first_step(double turn) const {
  double speed = 0, gain = 0;  // 1/s, 1/s^2
  for (std::size_t i = 0; i < q_.size(); ++i) {
    speed = std::max(speed, std::abs(rate_[i]));
    gain = std::max(gain, std::abs(acceleration_[i]));
  }
  const double turned = 2 * turn / (speed + std::sqrt(speed * speed + 2 * gain * turn));
  return std::min(turned, kLongestFirst * longest_);
}

void Course::advance(World& world, double until, Counters& counters) {
  motion_->attach(world);
  if (time_ < until) advance_audited(world, until, counters);
}

void Course::store(World& world) {
  if (time_ == world.time) {
    motion_->store(world, q_.data(), rate_.data());
    return note_shown(time_);
  }
  const bool followed = rung_ == adams && adams_.longest() > 0;
  interpolate(world.time, followed ? adams_.past(1) : nullptr, adams_.past(0));
  motion_->store(world, q_between_.data(), rate_between_.data());
  note_shown(world.time);
}

void Course::refresh(Counters& counters) {
  if (fresh_) return;
  motion_->acceleration(time_, q_.data(), rate_.data(), acceleration_.data());
  fastest_ = motion_->fastest();
  counters.solves += 1;
  counters.work += motion_->work();
  fresh_ = true;
}

/// The error (m) of a step of h by one of the integrators that do not look back.
double Course::attempt(Rung rung, double h, Counters& counters) {
  const double *q = q_.data(), *rate = rate_.data(), *first = acceleration_.data();
  refresh(counters);
  counters.work += (cost_[rung] - 1) * motion_->work();
  if (rung == careful) {
    counters.solves += kStages - 1;
    return careful_.attempt(*motion_, time_, h, q, rate, first);
  }
  counters.solves += RosenbrockStep::kStages - 1;
  return implicit_.attempt(*motion_, time_, h, q, rate, first);
}

void Course::accept(Rung rung, double time, Counters& counters) {
  before_ = time_;
  q_before_.swap(q_);
  rate_before_.swap(rate_);
  time_ = time;
  counters.steps += 1;
  if (rung == careful) careful_.swap_result(q_, rate_);
  if (rung == adams) adams_.swap_result(q_, rate_);
  if (rung == implicit) implicit_.swap_result(q_, rate_);
  motion_->project(time_, q_.data(), rate_.data());
  fresh_ = false;
}

/// A hold has left the plane: goes on from where the last step ended, in another plane (a chain
/// that hangs still fits many) or in space.
bool Course::leave_plane(World& world) {
  const std::optional<Vec3> reason = motion_->left_plane();
  if (!reason) return false;
  place_prescribed(world, time_);
  motion_->store(world, q_.data(), rate_.data());
  std::optional<Plane> plane;
  if (planned_at_ != time_) plane = planes_.find(world, component_, time_, *reason);
  plan(world, time_, plane);
  closed_ = looks_back_ = false;
  motion_->load(world, time_, q_.data(), rate_.data());
  fresh_ = false;
  return true;
}

void Course::advance_by_tolerance(World& world, double until, Counters& counters) {
  while (time_ < until) {
    if (step_ == 0) {
      refresh(counters);
      step_ = first_step(kFirstTurn);
      if (step_ > stable_step(careful)) rung_ = implicit;
    }
    if (rung_ != adams) refresh(counters);
    double wish = std::min({step_, stable_step(rung_), longest_});
    if (rung_ == adams && adams_.longest() > 0) wish = std::min(wish, adams_.longest());
    double h = length_of_step(until, wish);
    Rung rung = rung_;
    double error = 0;
    if (rung_ == adams) {
      if (adams_.prepare(h)) {
        error = march(until, counters);
        if (leave_plane(world)) continue;
      } else {
        rung = careful;
        h = end_of_start(until, h) - time_;
      }
    }
    if (!(time_ + h > time_)) throw StepTooSmall{time_};
    if (rung != adams) {
      const double end = rung == rung_ ? end_of_step(until, h) : end_of_start(until, h / 3);
      error = attempt(rung, h, counters) / allowed_error(rung, h);
      if (leave_plane(world)) continue;
      if (error <= 1) {  // false for NaN
        if (rung_ == adams) {
          start_adams(end, counters);
        } else {
          accept(rung, end, counters);
          adams_.clear();
        }
      } else {
        counters.rejected += 1;
        fresh_ = fresh_ && rung == careful;  // the implicit one needs the tensions of this state
      }
    }
    if (rung != rung_ && !(error <= 1)) hand_over_to(careful, counters);
    if (rung == rung_) adapt(h, wish, error, counters);
  }
}

/// Takes the careful step that was tried, which Adams's begin from: with the accelerations at its
/// thirds.
void Course::start_adams(double time, Counters& counters) {
  const auto [latest, later, earlier, first] = adams_.begin((time - time_) / 3);
  std::copy(acceleration_.begin(), acceleration_.end(), first);
  accept(careful, time, counters);
  refresh(counters);
  std::copy(acceleration_.begin(), acceleration_.end(), latest);
  for (const auto& [share, out] : {std::pair(1.0 / 3, earlier), std::pair(2.0 / 3, later)}) {
    const double at = before_ + share * (time_ - before_);
    interpolate(at, first, latest);
    motion_->acceleration(at, q_between_.data(), rate_between_.data(), out);
    counters.solves += 1;
    counters.work += motion_->work();
  }
  fresh_ = false;  // the last tensions are others
}

/// Takes steps of Adams's spacing as far as `until`, for as long as waves and error suit it.
/// Returns the error of the last one, as a share of the one allowed.
double Course::march(double until, Counters& counters) {
  const double h = adams_.spacing(), share = allowed_error(adams, h);
  double error = 0;
  int& rest = rests_[implicit].steps;
  while (time_ < until) {
    counters.solves += 1;
    counters.work += cost_[adams] * motion_->work();
    error = adams_.attempt(*motion_, time_, q_.data(), rate_.data(), kLittle * share) / share;
    if (motion_->left_plane()) return error;
    if (!(error <= 1)) {
      counters.rejected += 1;
      return error;
    }
    adams_.accept();
    accept(adams, end_of_step(until, h), counters);
    fastest_ = motion_->fastest();
    const double waves = h * fastest_ / AdamsStep::kStable;
    if (waves > 1 || error > kMuch) return error;
    if ((error < kLittle && waves < kLeastSpacing) || --rest <= 0) return error;
  }
  return error;
}

/// Chooses the next step and its integrator from how a step of h went where `wish` was possible.
void Course::adapt(double h, double wish, double error, Counters& counters) {
  // Of the error as a share of the one allowed, which grows with the step.
  constexpr double kOrder[kRungs] = {Dop853Step::kErrorOrder - 1, AdamsStep::kErrorOrder - 1,
                                     RosenbrockStep::kErrorOrder};
  // h may be far shorter than what is possible, to end with the frame.
  const double most = std::max(kMostGrowth * h, wish);
  const double scaled = scaled_step(h, error, kOrder[rung_]);
  step_ = std::min(scaled, most);
  const double speed = std::min(rough_ ? scaled : step_, stable_step(rung_)) / cost_[rung_];
  if (rung_ != careful) {
    const Rung below = rough_ ? careful : static_cast<Rung>(rung_ - 1);
    double limit = stable_step(below);
    if (rung_ == adams) limit = std::min(limit, reach_ / fastest_);
    if (below == adams) limit *= kLikely;
    if (rough_) limit = std::min(limit, kLongestFirst * longest_) / kWorthwhile;
    if (speed < limit / cost_[below]) {
      hand_over_to(below, counters);
      step_ = rung_ == adams && adams_.longest() > 0 ? adams_.spacing() : limit;
      return;
    }
    if (error <= 1 && ++rests_[rung_].steps > rests_[rung_].interval) {
      rests_[rung_].interval = kShortestRest;
    }
  }
  if (rung_ == careful) reach_ = step_ * fastest_;
  const bool waves = !rough_ && rung_ == careful && step_ > kHeldUp * stable_step(careful);
  if (waves && --rests_[adams].steps <= 0) {
    climb(adams, std::min(stable_step(adams), step_ / 3));
  } else if (rung_ != implicit && --rests_[implicit].steps <= 0) {
    climb(implicit, speed * cost_[implicit]);
  }
}

/// Goes down the ladder, and lets the rung that failed rest.
void Course::hand_over_to(Rung below, Counters& counters) {
  Rest& rest = rests_[rung_];
  rest.steps = rest.interval;
  rest.interval = std::min(4 * rest.interval, kLongestRest);
  rung_ = below;
  counters.handed_over += 1;
}

void Course::climb(Rung to, double step) {
  rung_ = to;
  step_ = step;
  rests_[to].steps = 0;
}

/// Fixed steps: the careful integrator where it is stable, else the implicit one. A step that goes
/// astray is done again in smaller ones.
void Course::advance_by_step(World& world, double until, Counters& counters) {
  const StepTimes times(time_, until, control_.step);
  for (std::uint64_t i = 1; i <= times.count; ++i) {
    const double end = times.at(i);
    while (time_ < end) {
      refresh(counters);
      const double h = end - time_;
      rung_ = h > stable_step(careful) ? implicit : careful;
      const double error = attempt(rung_, h, counters);
      if (leave_plane(world)) continue;
      if (error <= tolerance_) {
        accept(rung_, end, counters);
        continue;
      }
      counters.rejected += 1;
      counters.handed_over += 1;
      rung_ = careful;
      step_ = h / 2;
      advance_by_tolerance(world, end, counters);
    }
  }
}

}  // namespace taut::direct
