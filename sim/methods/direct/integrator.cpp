#include "sim/methods/direct/integrator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/methods/direct/system/links.h"
#include "sim/motion/stop.h"

namespace taut::direct {
namespace {

bool driven(const World& world, const Component& component) {
  for (const SpanRange& span : component.spans) {
    for (const std::size_t particle : {span.first, span.last}) {
      const Hold* hold = find_hold(world.connectors[span.connector], particle);
      if (hold && is_prescribed(world, hold->to) && !rests(hold->to, world.time)) return true;
    }
  }
  return false;
}

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// The step whose error would be the one allowed, after one of h that had `error` times that.
double scaled_step(double h, double error, double order) {
  constexpr double kLeast = 1 / kConstants.most_change;
  if (!std::isfinite(error)) return h * kLeast;
  return h * std::max(kLeast, kConstants.safety * std::pow(error, -1 / order));
}

}  // namespace

Integrator::Integrator(const StepOptions& options)
    : options_(options),
      larger_{std::pow(options.finer, Dop853Step::kErrorOrder),
              std::pow(options.finer, AdamsStep::kErrorOrder),
              std::pow(options.finer, RosenbrockStep::kErrorOrder)} {
  tries_.fill(options.finer == 1);
}

void Integrator::reserve(std::size_t links, std::size_t ends) {
  planes_.reserve(links);
  system_.reserve(links, ends);
  const std::size_t size = 3 * (links + kLanes) + 4 * ends + 2 * Links::kPad;
  arena_.reserve(kArrays, size);
}

void Integrator::plan(const World& world, double time, const std::optional<Plane>& plane) {
  planned_at_ = time;
  system_.rebuild(world, component_, plane);
  arena_.reset(kArrays, system_.size());
  for (Slice* slice :
       {&q_, &rate_, &acceleration_, &q_before_, &rate_before_, &q_between_, &rate_between_}) {
    *slice = arena_.make();
  }
  dop853_.make_results(arena_);
  rosenbrock_.make_results(arena_);
  adams_.make_arrays(arena_);
  // One of them tries a step at a time.
  Arena::Line* const workspace = arena_.mark();
  dop853_.make_workspace(arena_);
  arena_.rewind(workspace);
  rosenbrock_.make_workspace(arena_);
  longest_ = driven(world, component_) ? kConstants.longest_driven : kConstants.longest;
  cost_ = {Dop853Step::kCost, AdamsStep::kCost, RosenbrockStep::kCost};
  for (double& cost : cost_) cost += system_.projection_cost();
}

void Integrator::load(const World& world) {
  plan(world, world.time, planes_.find(world, component_, world.time, Vec3::Zero()));
  time_ = world.time;
  system_.load(world, time_, q_.data(), rate_.data());
  system_.project(time_, q_.data(), rate_.data());
  begin();
}

/// Knows nothing but the state.
void Integrator::begin() {
  fresh_ = false;
  scheme_ = dop853;
  step_ = 0;
  watch_.start(time_);
  last_turn_ = Dop853Step::kStable;
  rests_.fill({0, kConstants.shortest_rest});
}

// How far a step of each scheme may go, how wrong it may be, and where it has to end.

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
  return std::min(options_.asked(length), kConstants.largest * length);
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

// The state at a time within the last step.

namespace {

/// The state between two others, at the share s of the way that takes h, by Hermite's polynomial:
/// of degree 3 or, with the accelerations at both, 5.
template <bool kWithAccelerations>
[[gnu::always_inline]] inline void hermite(std::size_t n, double h, double s,
                                           const double* const (&first)[3],
                                           const double* const (&last)[3], double* __restrict q,
                                           double* __restrict rate) {
  const double half = h * h / 2;
  const double bump = s * s * (1 - s) * (1 - s), rise = 2 * s * (1 - s) * (1 - 2 * s);
  for (std::size_t i = 0; i < n; ++i) {
    const double start = h * first[1][i], end = h * last[1][i], gone = last[0][i] - first[0][i];
    const double c2 = 3 * gone - 2 * start - end, c3 = start + end - 2 * gone;
    double place = first[0][i] + s * (start + s * (c2 + s * c3));
    double way = start + s * (2 * c2 + s * 3 * c3);
    if constexpr (kWithAccelerations) {
      const double u = half * first[2][i] - c2, v = half * (last[2][i] - first[2][i]) - 3 * c3;
      place += bump * (u + s * v);
      way += rise * (u + s * v) + bump * v;
    }
    q[i] = place;
    rate[i] = way / h;
  }
}

TAUT_VECTOR_CLONES
void cubic(std::size_t n, double h, double s, const double* const (&first)[3],
           const double* const (&last)[3], double* q, double* rate) {
  hermite<false>(n, h, s, first, last, q, rate);
}

TAUT_VECTOR_CLONES
void quintic(std::size_t n, double h, double s, const double* const (&first)[3],
             const double* const (&last)[3], double* q, double* rate) {
  hermite<true>(n, h, s, first, last, q, rate);
}

}  // namespace

/// The state at `time` within the last step, by Hermite's polynomial. Accelerations count in it
/// where Adams follows every wave; the implicit scheme passes over them.
void Integrator::interpolate(double time, const double* first_acceleration,
                             const double* last_acceleration) {
  const double h = time_ - before_, s = (time - before_) / h;
  const double* const first[] = {q_before_.data(), rate_before_.data(), first_acceleration};
  const double* const last[] = {q_.data(), rate_.data(), last_acceleration};
  (first_acceleration ? quintic : cubic)(q_.size(), h, s, first, last, q_between_.data(),
                                         rate_between_.data());
  if (!system_.project(time, q_between_.data(), rate_between_.data())) throw StepTooSmall{time};
  if (system_.projection_cost() > 0) fresh_ = false;  // that may have changed the tensions
}

// Its steps.

void Integrator::advance(World& world, double until, Counters& counters) {
  system_.attach(world);
  system_.renumber(component_);
  if (time_ < until && options_.step > 0) return advance_by_step(world, until, counters);
  advance_by_tolerance(world, until, counters);
}

/// Sums of steps miss a time by roundings, which no step can make up for.
bool Integrator::is_before(double until) {
  constexpr double kRoundings = 4 * std::numeric_limits<double>::epsilon();
  if (std::abs(time_ - until) <= kRoundings * std::abs(until)) time_ = until;
  return time_ < until;
}

void Integrator::store(World& world) {
  system_.renumber(component_);
  if (time_ == world.time) return system_.store(world, q_.data(), rate_.data());
  const bool followed = scheme_ == adams && adams_.longest() > 0;
  interpolate(world.time, followed ? adams_.past(1) : nullptr, adams_.past(0));
  system_.store(world, q_between_.data(), rate_between_.data());
}

double Integrator::tension(double time, std::size_t connector, Counters& counters) {
  if (time == time_) {
    refresh(counters);
  } else {
    system_.acceleration(time, q_between_.data(), rate_between_.data(), acceleration_.data());
    counters.solves += 1;
    counters.cycles += system_.cycles();
    fresh_ = false;
  }
  return system_.tension(system_.first_link(connector));
}

void Integrator::refresh(Counters& counters) {
  if (fresh_) return;
  system_.acceleration(time_, q_.data(), rate_.data(), acceleration_.data());
  waves_ = system_.wave_frequency();
  counters.solves += 1;
  counters.cycles += system_.cycles();
  fresh_ = true;
}

/// A step of h by one of the schemes of one step.
StepError Integrator::attempt(Scheme scheme, double h, Counters& counters) {
  const double *q = q_.data(), *rate = rate_.data(), *first = acceleration_.data();
  refresh(counters);
  counters.cycles += (cost_[scheme] - 1) * system_.cycles();
  if (scheme == dop853) {
    counters.solves += kStages - 1;
    const double error = dop853_.attempt(system_, time_, h, q, rate, first);
    return {error, error, 0};
  }
  counters.solves += RosenbrockStep::kStages - 1;
  return rosenbrock_.attempt(system_, time_, h, q, rate, first);
}

/// Goes on from where a step ended. False where loops do not close there: then from where it began.
bool Integrator::accept(Scheme scheme, double time, Counters& counters) {
  const auto swap_result = [&] {
    if (scheme == dop853) dop853_.swap_result(q_, rate_);
    if (scheme == adams) adams_.swap_result(q_, rate_);
    if (scheme == rosenbrock) rosenbrock_.swap_result(q_, rate_);
  };
  fresh_ = false;
  q_before_.swap(q_);
  rate_before_.swap(rate_);
  swap_result();
  if (!system_.project(time, q_.data(), rate_.data())) {
    swap_result();
    q_before_.swap(q_);
    rate_before_.swap(rate_);
    adams_.clear();
    return false;
  }
  before_ = time_;
  time_ = time;
  last_ = {scheme, limit_, time_ - before_, waves_};
  counters.steps += 1;
  taken_[scheme] += 1;
  if (!watch_.count(time_)) throw StepTooSmall{time_};
  return true;
}

/// A hold has left the plane: goes on from where the last step ended, in another plane (a chain
/// that hangs still fits many) or in space.
bool Integrator::leave_plane(World& world) {
  const std::optional<Vec3> reason = system_.left_plane();
  if (!reason) return false;
  place_prescribed(world, time_);
  system_.store(world, q_.data(), rate_.data());
  std::optional<Plane> plane;
  if (planned_at_ != time_) plane = planes_.find(world, component_, time_, *reason);
  plan(world, time_, plane);
  system_.load(world, time_, q_.data(), rate_.data());
  fresh_ = false;
  return true;
}

void Integrator::advance_by_tolerance(World& world, double until, Counters& counters) {
  while (is_before(until)) {
    check_stop();
    if (step_ == 0) {
      refresh(counters);
      step_ = first_step();
    }
    if (scheme_ != adams || adams_.longest() == 0) refresh(counters);
    double wish = std::min({step_, stable_step(scheme_), longest_ / options_.finer});
    if (scheme_ == adams && adams_.longest() > 0) wish = std::min(wish, adams_.longest());
    double h = length_of_step(until, wish);
    limit_ = h < kConstants.safety * wish        ? Limit::frame
             : wish >= stable_step(scheme_)      ? Limit::waves
             : wish >= longest_ / options_.finer ? Limit::longest
                                                 : Limit::error;
    Scheme scheme = scheme_;
    double error = 0;
    if (scheme_ == adams) {
      if (adams_.prepare(h)) {
        error = advance_adams(until, counters);
        if (leave_plane(world)) continue;
      } else {
        scheme = dop853;
        h = end_of_start(until, h) - time_;
      }
    }
    if (!(time_ + h > time_)) throw StepTooSmall{time_};
    if (scheme != adams) {
      const double end = scheme == scheme_ ? end_of_step(until, h) : end_of_start(until, h / 3);
      error = share_of_allowed(scheme, h, attempt(scheme, h, counters));
      if (leave_plane(world)) continue;
      const auto take = [&] {
        if (scheme_ == adams) return start_adams(end, counters);
        adams_.clear();
        return accept(scheme, end, counters);
      };
      if (error <= 1 && !take()) error = kInfinite;
      if (!(error <= 1)) {  // true for NaN
        if (is_lost(scheme, h)) throw StepTooSmall{time_};
        counters.rejected += 1;
        fresh_ = fresh_ && scheme == dop853;  // the implicit one needs this state's tensions
      }
    }
    if (scheme != scheme_ && !(error <= 1)) hand_over_to(dop853, counters);
    if (scheme == scheme_) adapt(h, wish, error, counters);
  }
}

/// Takes DOP853's step that was tried, from which Adams begins: with the accelerations at its
/// thirds.
bool Integrator::start_adams(double time, Counters& counters) {
  const auto [latest, later, earlier, first] = adams_.begin((time - time_) / 3);
  std::copy(acceleration_.begin(), acceleration_.end(), first);
  if (!accept(dop853, time, counters)) return false;
  refresh(counters);
  std::copy(acceleration_.begin(), acceleration_.end(), latest);
  for (const auto& [share, out] : {std::pair(1.0 / 3, earlier), std::pair(2.0 / 3, later)}) {
    const double at = before_ + share * (time_ - before_);
    interpolate(at, first, latest);
    system_.acceleration(at, q_between_.data(), rate_between_.data(), out);
    counters.solves += 1;
    counters.cycles += system_.cycles();
  }
  fresh_ = false;  // the last tensions are others
  return true;
}

/// Takes steps of Adams's spacing as far as `until`, for as long as waves and error suit it.
/// Returns the error of the last one, as a share of the one allowed.
double Integrator::advance_adams(double until, Counters& counters) {
  // adapt() would shorten the step above the one error, and could lengthen it beyond a respacing
  // below the other.
  static const double kMuch = std::pow(kConstants.safety, AdamsStep::kErrorOrder - 1);
  static const double kLittle =
      std::pow(kConstants.safety * AdamsStep::kLeastSpacing, AdamsStep::kErrorOrder);
  const double h = adams_.spacing(), allowed = allowed_error(adams, h);
  double error = 0;
  int& rest = rests_[rosenbrock].steps;
  while (is_before(until)) {
    check_stop();
    counters.solves += 1;
    counters.cycles += cost_[adams] * system_.cycles();
    error = adams_.attempt(system_, time_, q_.data(), rate_.data(), kLittle * allowed) / allowed;
    if (system_.left_plane()) return error;
    if (!(error <= 1)) {
      counters.rejected += 1;
      return error;
    }
    adams_.accept();
    if (!accept(adams, end_of_step(until, h), counters)) {
      counters.rejected += 1;
      return kInfinite;
    }
    waves_ = system_.wave_frequency();
    const double waves = options_.finer * h * waves_ / AdamsStep::kStable;
    if (waves > 1 || error > kMuch) return error;
    if ((error < kLittle && waves < AdamsStep::kLeastSpacing) || --rest <= 0) return error;
  }
  return error;
}

/// Chooses the next step and its scheme from how a step of h went where `wish` was possible.
void Integrator::adapt(double h, double wish, double error, Counters& counters) {
  // Of the error as a share of the one allowed, which grows with the step.
  constexpr double kOrder[kSchemes] = {Dop853Step::kErrorOrder - 1, AdamsStep::kErrorOrder - 1,
                                       RosenbrockStep::kErrorOrder};
  // h may be far shorter than what is possible, to end with the frame.
  const double most = std::max(kConstants.most_change * h, wish);
  step_ = std::min(scaled_step(h, error, kOrder[scheme_]), most);
  const double speed = std::min(step_, stable_step(scheme_)) / cost_[scheme_];
  if (scheme_ != dop853) {
    const auto before = static_cast<Scheme>(scheme_ - 1);
    double limit = stable_step(before);
    if (scheme_ == adams) limit = std::min(limit, last_turn_ / waves_);
    if (before == adams) limit *= kConstants.safety;
    if (speed < limit / cost_[before]) {
      hand_over_to(before, counters);
      step_ = scheme_ == adams && adams_.longest() > 0 ? adams_.spacing() : limit;
      return;
    }
    Rest& rest = rests_[scheme_];
    if (error <= 1 && ++rest.steps > rest.interval) rest.interval = kConstants.shortest_rest;
  }
  if (scheme_ == dop853) last_turn_ = step_ * waves_;
  const bool held_up = scheme_ == dop853 && step_ > kConstants.held_up * stable_step(dop853);
  if (held_up && tries_[adams] && --rests_[adams].steps <= 0) {
    try_next(adams, std::min(stable_step(adams), step_ / 3));
  } else if (scheme_ != rosenbrock && tries_[rosenbrock] && --rests_[rosenbrock].steps <= 0) {
    try_next(rosenbrock, speed * cost_[rosenbrock]);
  }
}

/// Lets the scheme that failed rest.
void Integrator::hand_over_to(Scheme before, Counters& counters) {
  Rest& rest = rests_[scheme_];
  rest.steps = rest.interval;
  rest.interval = std::min(4 * rest.interval, kConstants.longest_rest);
  scheme_ = before;
  counters.handed_over += 1;
}

void Integrator::keep_to_schemes_of(const Integrator& other) {
  for (std::size_t s = 0; s < kSchemes; ++s) {
    tries_[s] = other.taken_[s] > seen_[s];
    seen_[s] = other.taken_[s];
  }
}

void Integrator::try_next(Scheme next, double step) {
  scheme_ = next;
  step_ = step;
  rests_[next].steps = 0;
}

/// Fixed steps: DOP853 where it is stable, else the implicit scheme. A step that goes astray is
/// done again in smaller ones.
void Integrator::advance_by_step(World& world, double until, Counters& counters) {
  const double coarsest = asked_error();
  const StepTimes times(time_, until, options_.step);
  for (std::uint64_t i = 1; i <= times.count; ++i) {
    const double end = times.at(i);
    while (time_ < end) {
      check_stop();
      refresh(counters);
      const double h = end - time_;
      scheme_ = h > stable_step(dop853) ? rosenbrock : dop853;
      const double error = attempt(scheme_, h, counters).all;
      if (leave_plane(world)) continue;
      watch_.start(time_);
      if (error <= coarsest && accept(scheme_, end, counters)) continue;
      counters.rejected += 1;
      counters.handed_over += 1;
      scheme_ = dop853;
      step_ = h / 2;
      advance_by_tolerance(world, end, counters);
    }
  }
}

}  // namespace taut::direct
