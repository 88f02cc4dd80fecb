#include "sim/methods/direct/joined.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/measure/measure.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/schemes/dop853.h"
#include "sim/methods/direct/system/system.h"
#include "sim/topology/components.h"

namespace taut::direct {
namespace {

constexpr double kFirst = 0.1;  // of the shortest link's swing: the first step

Eigen::Map<const Vec3> part(const std::vector<double>& state, std::size_t at) {
  return Eigen::Map<const Vec3>(&state[at]);
}

/// sum_k weights[k] slopes[k] of the first `count` stages, times h, on top of `from`.
void add_up(const Dop853::Row& weights, int count, double h,
            const std::array<std::vector<double>, kAllStages>& slopes, std::vector<double>& to) {
  for (int k = 0; k < count; ++k) {
    const double weight = h * weights[static_cast<std::size_t>(k)];
    if (weight == 0) continue;
    const std::vector<double>& slope = slopes[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += weight * slope[i];
  }
}

}  // namespace

void Joined::rebuild(const World& world) {
  built_ = true;
  topology_ = world.topology;
  mechanism_.rebuild(world);
  system_.rebuild(mechanism_);
  projection_.rebuild(mechanism_);
  friction_.rebuild(mechanism_);
  const std::size_t size = mechanism_.state_size(), rows = mechanism_.unknowns();
  for (State* state : {&state_, &before_, &shown_, &loaded_, &next_, &scratch_, &error_}) {
    state->assign(size, 0.0);
  }
  for (State& state : slope_) state.assign(size, 0.0);
  for (State* state : {&right_, &tension_}) state->assign(rows, 0.0);
  length_ = length_scale(world);
  shortest_ = length_;
  driven_ = has_winches(world);
  for (const Connector& connector : world.connectors) {
    for (const double rest : connector.rest) {
      if (rest > 0) shortest_ = std::min(shortest_, rest);
    }
    for (const Hold& hold : connector.holds) {
      driven_ = driven_ || (is_prescribed(world, hold.to) && !rests(hold.to, world.time)) ||
                hold.turn != nullptr;
    }
  }
  const auto& easy = mechanism_.inverse_mass();
  lone_.clear();
  for (std::size_t b = 0; b < mechanism_.bodies().size(); ++b) {
    const Mechanism::FreeBody& body = mechanism_.bodies()[b];
    if (std::ranges::find(mechanism_.body_points(), b, &Mechanism::BodyPoint::body) !=
        mechanism_.body_points().end())
      continue;
    lone_.push_back({b, std::sqrt(body.inertia.trace() / 2 * body.inverse_mass)});
  }
  carried_ =
      static_cast<double>(mechanism_.body_points().size() + mechanism_.pulleys() + lone_.size());
  for (const double inverse_mass : easy) carried_ += inverse_mass > 0 ? 1 : 0;
  find_material_waves();
}

bool Joined::is_stiff(const World& world) {
  constexpr double kStiff = 5e4;  // rad/s
  if (!built_ || topology_ != world.topology) {
    rebuild(world);
    shown_.clear();
  }
  return material_waves_ > kStiff;
}

void Joined::find_material_waves() {
  material_waves_ = 0;
  if (!mechanism_.material().any()) return;
  easy_ = mechanism_.inverse_mass();
  for (const Mechanism::BodyPoint& at : mechanism_.body_points()) {
    // The most that a push at a point of the body moves it there, or at another of its points.
    const Mechanism::FreeBody& body = mechanism_.bodies()[at.body];
    double arms = 0, count = 0;
    for (const Mechanism::BodyPoint& other : mechanism_.body_points()) {
      if (other.body != at.body) continue;
      arms += other.local.norm();
      ++count;
    }
    easy_[at.point] =
        count * body.inverse_mass + at.local.norm() * arms * body.inverse_inertia.norm();
  }
  const auto mode = mechanism_.material().highest_mode(easy_);
  material_waves_ = std::max(mode.frequency, mode.damping);
}

void Joined::find_slope(double time, const State& state, State& slope) {
  scratch_ = state;
  mechanism_.update(time, scratch_.data());
  mechanism_.right_side(right_);
  system_.assemble(mechanism_);
  system_.solve(right_, tension_);
  mechanism_.differentiate(scratch_.data(), tension_.data(), slope.data());
  ++counters_.solves;
  counters_.cycles +=
      mechanism_.cycles() + system_.cycles() + 12 * static_cast<double>(slope.size());
}

/// A bound on the frequency (rad/s) of the waves under the last tensions: Gershgorin's on M^-1 K, K
/// the links' tensions over their lengths.
double Joined::wave_frequency() {
  const auto& rows = mechanism_.rows();
  const auto& easy = mechanism_.inverse_mass();
  State& stiff = error_;  // of no use between two attempts
  std::ranges::fill(stiff, 0.0);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r].axis != Row::kAlongLink) continue;
    const double k = 2 * std::abs(tension_[r]) / rows[r].rest;
    stiff[rows[r].a] += k;
    stiff[rows[r].b] += k;
  }
  double most = 0;
  for (std::size_t p = 0; p < mechanism_.points(); ++p) most = std::max(most, easy[p] * stiff[p]);
  return std::hypot(std::sqrt(most), material_waves_);
}

double Joined::first_step() const {
  return kFirst * std::sqrt(shortest_ / std::max(world_->gravity.norm(), 1.0));
}

double Joined::order() const {
  return Dop853Step::kErrorOrder;
}

double Joined::longest_step(double time) {
  find_slope(time, state_, slope_[0]);
  const double waves = wave_frequency();
  const double longest = driven_ ? kConstants.longest_driven : kConstants.longest;
  return std::min(longest, Dop853Step::kStable / std::max(waves, Dop853Step::kStable / longest)) /
         options_.finer;
}

/// The error (m) that a step of h may make: as any step of this method (Integrator).
double Joined::allowed_error(double h) const {
  const double share = std::min(kConstants.rate * options_.finer * h, kConstants.share);
  const double rough = kConstants.turn * shortest_ / kConstants.share;
  return share * std::min(options_.asked(length_), rough) /
             std::pow(options_.finer, Dop853Step::kErrorOrder) +
         kConstants.roundings * std::numeric_limits<double>::epsilon() * length_;
}

/// The error (m) of positions that those of a state amount to, RMS over all that moves freely.
double Joined::size(const State& error) const {
  const double time = velocity_time_of(length_);
  double sum = 0;
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    sum += part(error, mechanism_.position(p)).squaredNorm() +
           time * time * part(error, mechanism_.velocity(p)).squaredNorm();
  }
  const auto add_point = [&](std::size_t body, double arm) {
    const std::size_t pose = mechanism_.pose(body), twist = mechanism_.twist(body);
    const double turn = 2 * Eigen::Map<const Eigen::Vector4d>(&error[pose + 3]).norm();
    const double place = part(error, pose).norm() + arm * turn;
    const double speed = part(error, twist).norm() + arm * part(error, twist + 3).norm();
    sum += place * place + time * time * speed * speed;
  };
  for (const Mechanism::BodyPoint& point : mechanism_.body_points())
    add_point(point.body, point.local.norm());
  for (const Lone& lone : lone_) add_point(lone.body, lone.arm);
  for (std::size_t p = 0; p < mechanism_.pulleys(); ++p) {
    const double place = error[mechanism_.passed(p)], speed = error[mechanism_.speed(p)];
    sum += place * place + time * time * speed * speed;
  }
  return std::sqrt(sum / std::max(carried_, 1.0));
}

/// A step from state_, whose slope is the first, to next_; the estimate of its error (m).
double Joined::try_step(double time, double h) {
  for (int s = 1; s < kStages; ++s) {
    const auto stage = static_cast<std::size_t>(s);
    next_ = state_;
    add_up(kDop853.stage[stage], s, h, slope_, next_);
    find_slope(time + kDop853.node[stage] * h, next_, slope_[stage]);
  }
  next_ = state_;
  add_up(kDop853.stage[kStages], kStages, h, slope_, next_);
  const auto estimate = [&](const Dop853::Row& weights) {
    std::ranges::fill(error_, 0.0);
    add_up(weights, kStages, h, slope_, error_);
    return size(error_);
  };
  const double error5 = estimate(kDop853.error5), error3 = estimate(kDop853.error3);
  const double blend = std::hypot(error5, 0.1 * error3);  // Hairer's, of order 8
  return blend > 0 ? error5 * error5 / blend : blend;
}

/// As PulleyFriction has it.
double Joined::distance_to_change(double time, State& state) {
  return friction_.any() ? friction_.distance(mechanism_, system_, time, state) : kNever;
}

bool Joined::project(double time, State& state) {
  if (!(projection_.lengths(mechanism_, time, state).violation <= Projection::kKept)) return false;
  projection_.rates(mechanism_, time, state);
  return true;
}

/// Whether steps, which may be as long as `wish`, end at the time that is asked for and `left`
/// away: where equal parts of the way are cheaper than steps of that length and a state within the
/// last one; where events are looked for at the ends of steps; and where how long a step may be
/// changes with a length.
bool Joined::lands(double left, double wish) const {
  const bool lengths_stiffen = mechanism_.has_winches() && mechanism_.material().any();
  if (options_.step > 0 || friction_.any() || lengths_stiffen) return true;
  constexpr double kWithin = kAllStages - kStages;  // slopes, of a step's twelve
  const double steps = left / wish;
  return (std::ceil(steps - 1e-9) - steps) * kStages < kWithin;
}

void Joined::prepare_states_within() {
  if (within_known_) return;
  within_known_ = true;
  const double from = controller_.before(), to = controller_.time(), h = to - from;
  find_slope(to, state_, slope_[kStages]);
  for (std::size_t s = kStages + 1; s < kAllStages; ++s) {
    next_ = before_;
    add_up(kDop853.stage[s], static_cast<int>(s), h, slope_, next_);
    find_slope(from + kDop853.node[s] * h, next_, slope_[s]);
  }
}

/// Hairer's interpolation, of order 7 (see dop853_table.h).
void Joined::find_state_within(double time, State& state) {
  const double from = controller_.before(), h = controller_.time() - from;
  const double s = (time - from) / h, left = 1 - s;
  Dop853::Row weights{};
  for (std::size_t k = 0; k < kAllStages; ++k) {
    const auto& rows = kDop853.between;
    weights[k] = rows[0][k] + s * (rows[1][k] + left * (rows[2][k] + s * rows[3][k]));
  }
  std::ranges::fill(state, 0.0);
  add_up(weights, kAllStages, h, slope_, state);
  for (std::size_t i = 0; i < state.size(); ++i) {
    const double gone = state_[i] - before_[i], bend = h * slope_[0][i] - gone;
    const double rest = gone - h * slope_[kStages][i] - bend + left * state[i];
    state[i] = before_[i] + s * (gone + left * (bend + s * rest));
  }
}

void Joined::advance(World& world, double until) {
  const bool fresh = !built_ || topology_ != world.topology;
  if (fresh) rebuild(world);
  world_ = &world;
  mechanism_.load(world, loaded_);
  if (fresh || loaded_ != shown_) {
    state_ = loaded_;
    controller_.start(world.time);
    if (!project(world.time, state_)) give_up(world.time);
    if (friction_.any()) friction_.decide(mechanism_, system_, world.time, state_);
  }
  if (mechanism_.has_winches()) find_material_waves();
  to_change_ = distance_to_change(controller_.time(), state_);
  controller_.follow(*this, until, counters_);
  if (controller_.time() == until) {
    mechanism_.store(state_, until, world);
    mechanism_.load(world, state_);
    shown_ = state_;
    return;
  }
  prepare_states_within();
  find_state_within(until, next_);
  if (!project(until, next_)) give_up(until);
  mechanism_.store(next_, until, world);
  mechanism_.load(world, shown_);
}

Attempt Joined::attempt(double time, double h, double until) {
  Attempt made{true, try_step(time, h), allowed_error(h)};
  if (!(made.error <= made.limit)) return made;
  if (const auto connector = mechanism_.run_through(time + h, next_.data())) {
    if (h < kConstants.brief && time + h <= until) {
      throw Diverged("direct", time, counters_.steps, world_->connectors[*connector].name, 0,
                     kRunThrough);
    }
    made.solved = false;
    return made;
  }
  made.solved = project(time + h, next_);
  if (!made.solved) return made;
  next_to_change_ = distance_to_change(time + h, next_);
  if (next_to_change_ < -PulleyFriction::kNear && h > kConstants.shortest) {
    made.event = h * PulleyFriction::share(to_change_, next_to_change_);
  }
  return made;
}

void Joined::accept(double time) {
  std::swap(before_, state_);
  std::swap(state_, next_);
  within_known_ = false;
  to_change_ = next_to_change_;
  if (to_change_ <= PulleyFriction::kNear) {
    friction_.decide(mechanism_, system_, time, state_);
    to_change_ = distance_to_change(time, state_);
  }
  mechanism_.follow(time, state_);
}

void Joined::give_up(double time) {
  throw no_step(*world_, mechanism_, state_.data(), time, counters_.steps);
}

}  // namespace taut::direct
