#include "sim/methods/direct/implicit.h"

#include <algorithm>
#include <cmath>

#include "sim/measure/measure.h"
#include "sim/methods/direct/constants.h"
#include "sim/methods/direct/full_length.h"
#include "sim/methods/direct/system/system.h"
#include "sim/motion/stop.h"

namespace taut::direct {
namespace {

using PlaceAt = Eigen::Map<const Vec3>;

constexpr double kShortestJam = 1e-6;   // s
constexpr double kLeastFriction = 0.2;  // of all of it, with which a jam is tried
constexpr double kFades = 8;            // steps so many times as long say that no jam is left
constexpr double kOrderOfHalves = 2;
/// A step of h seconds may err by kErrorRate h tolerances, within these bounds: errors of short
/// steps come from waves and changes, and die away.
constexpr double kErrorRate = 0.4, kLeastShare = 1e-3, kMostShare = 0.01;
/// The error of a velocity counts as the distance that it covers in so many steps: a wave that
/// steps hardly resolve goes no farther.
constexpr double kWaves = 10;
/// The share of the tolerance by which a step may err in which contacts or strings change.
constexpr double kChangeShare = 0.1;
/// The power of StepOptions::finer by which the error of a step falls, so that the error of the
/// whole falls enough to tell it by the difference.
constexpr double kFinerPower = 5;

}  // namespace

void Implicit::rebuild(const World& world) {
  built_ = true;
  topology_ = world.topology;
  step_.rebuild(world);
  rate_.clear();
  length_ = length_scale(world);
  shortest_ = length_;
  for (const Connector& connector : world.connectors) {
    for (const double rest : connector.rest) {
      if (rest > 0) shortest_ = std::min(shortest_, rest);
    }
  }
  // In a fixed step nothing falls farther.
  const double fall = world.gravity.norm() * options_.step * options_.step;
  const double tolerance =
      options_.step > 0 ? std::min(options_.tolerance, fall) : options_.tolerance;
  touching_ = std::clamp(1e-3 * tolerance, 1e-12 * length_, 1e-5 * length_);
  step_.set_lowest_speeds(std::sqrt(2 * world.gravity.norm() * 0.1 * tolerance),
                          touching_ / velocity_time_of(length_));
}

/// The error (m) that the halves of a step of h may make. Extrapolation leaves of it a part that
/// falls by the power 3/2 of the whole, in units of the length.
double Implicit::allowed_error(double h) const {
  const double share = std::clamp(kErrorRate * options_.finer * h, kLeastShare, kMostShare);
  const double rough = kConstants.turn * shortest_ / kConstants.share;
  const double most = std::min(options_.asked(length_), rough);
  const double gain = std::max(1.0, std::cbrt(length_ / most));
  return share * gain * most / std::pow(options_.finer, kFinerPower) +
         kConstants.roundings * 2.2e-16 * length_;
}

/// The error (m) that a step may make in which contacts or strings change: once, however short.
double Implicit::allowed_change() const {
  return kChangeShare * options_.asked(length_) / std::pow(options_.finer, kFinerPower) +
         kConstants.roundings * 2.2e-16 * length_;
}

/// The distance (m) of two states, RMS over all that moves freely, with velocities times `time`
/// (s).
double Implicit::size(const StepState& one, const StepState& other, double time) const {
  const Mechanism& mechanism = step_.mechanism();
  const auto apart = [&](std::size_t at) {
    return Vec3(PlaceAt(&one.state[at]) - PlaceAt(&other.state[at]));
  };
  double sum = 0, count = 0;
  for (std::size_t p = 0; p < mechanism.points(); ++p) {
    if (mechanism.inverse_mass()[p] == 0) continue;
    sum += apart(mechanism.position(p)).squaredNorm() +
           time * time * apart(mechanism.velocity(p)).squaredNorm();
    ++count;
  }
  for (std::size_t b = 0; b < mechanism.bodies().size(); ++b) {
    const auto& body = mechanism.bodies()[b];
    const double arm = std::sqrt(body.inertia.norm() * body.inverse_mass);
    const std::size_t pose = mechanism.pose(b), twist = mechanism.twist(b);
    double turn = 0;
    for (std::size_t i = 3; i < 7; ++i) {
      turn += std::pow(one.state[pose + i] - other.state[pose + i], 2);
    }
    const double place = apart(pose).norm() + 2 * arm * std::sqrt(turn);
    const double speed = apart(twist).norm() + arm * apart(twist + 3).norm();
    sum += place * place + time * time * speed * speed;
    ++count;
  }
  for (std::size_t p = 0; p < mechanism.pulleys(); ++p) {
    const std::size_t passed = mechanism.passed(p), speed = mechanism.speed(p);
    const double place = one.state[passed] - other.state[passed];
    sum += place * place + time * time * std::pow(one.state[speed] - other.state[speed], 2);
    ++count;
  }
  return std::sqrt(sum / std::max(count, 1.0));
}

void Implicit::advance(World& world, double until, std::vector<Event>& events) {
  const auto tell = [&] {
    const auto later =
        std::ranges::find_if(events_, [&](const Event& event) { return event.time > until; });
    events.insert(events.end(), events_.begin(), later);
    events_.erase(events_.begin(), later);
  };
  if (!has_spans(world)) {
    advance_strings(world, until);
    return tell();
  }
  if (!built_ || spans_topology_ != world.topology) {
    spans_topology_ = world.topology;
    spans_.rebuild(world);
  }
  spans_.read(world);
  advance_strings(spans_.world(), until);
  spans_.write(world);
  const std::size_t told = events.size();
  tell();
  for (std::size_t i = told; i < events.size(); ++i) {
    for (const auto& place : spans_.places()) {
      if (events[i].of_contact || events[i].connector != place.string) continue;
      events[i].connector = place.span.connector;
      events[i].span = place.span.index;
      break;
    }
  }
}

void Implicit::advance_strings(World& world, double until) {
  world_ = &world;
  const bool fresh = !built_ || topology_ != world.topology;
  if (fresh) rebuild(world);
  if (!fresh) {
    Mechanism& mechanism = step_.mechanism();
    mechanism.load(world, loaded_);
  }
  if (fresh || loaded_ != shown_) {
    if (!step_.load(world, now_, touching_)) give_up(world.time);
    events_.clear();
    from_ = now_;
    controller_.start(now_.time);
  }
  jam_ = std::max(jam_, kShortestJam);
  controller_.follow(*this, until, counters_);
  step_.store(at(until), world);
  step_.mechanism().load(world, shown_);
}

/// The state at a time (s) within the last step. Where no step leads there, as far as they do.
const StepState& Implicit::at(double time) {
  if (now_.time == time) return now_;
  if (now_.time - time < kConstants.shortest) {
    within_ = now_;
    within_.time = time;
    return within_;
  }
  double longest = (time - from_.time) / 2;
  within_ = from_;
  while (within_.time < time) {
    check_stop();
    const double left = time - within_.time, h = std::min(left, longest);
    if (h < kConstants.shortest) break;
    if (step_.step(within_, h, touching_, false, end_) == ImplicitStep::Result::failed ||
        !step_.finish(end_, touching_, true)) {
      longest = h / 2;
      continue;
    }
    std::swap(within_, end_);
    if (h == left) within_.time = time;
  }
  within_.time = time;
  return within_;
}

double Implicit::first_step() const {
  return 0.1 * std::sqrt(shortest_ / std::max(world_->gravity.norm(), 1.0));
}

double Implicit::longest_step(double) {
  return std::min(kConstants.longest_driven / options_.finer, arrival_ahead());
}

/// s, until something is expected to arrive: a step that ends there need not be done again. Fixed
/// steps are cut only by what does arrive.
double Implicit::arrival_ahead() {
  constexpr double kBriefly = 0.01;  // of the last step: what is nearer is left to the step
  if (options_.step > 0) return kNever;
  const double ahead = step_.next_arrival(now_, rate_, touching_);
  return ahead > kBriefly * (now_.time - from_.time) ? ahead : kNever;
}

bool Implicit::lands(double, double) const {
  return false;
}

Attempt Implicit::attempt(double time, double h, double) {
  if (h < kConstants.shortest) give_up(time);
  for (;;) {
    Attempt made = try_step(h);
    counters_.solves = step_.factorisations();
    // As long as a jam lasts, steps with less friction become longer from one to the next.
    if (friction_ < 1) made.least = 2 * jam_;
    if (made.solved || made.event < kNever || h > jam_ || runs_through_) return made;
    // Shorter steps have no solution either: this one goes with less friction.
    if (friction_ == 0) {  // friction is not the cause: a shorter step, with all of it
      friction_ = 1;
      step_.set_friction_share(friction_);
      return made;
    }
    friction_ = friction_ > kLeastFriction ? friction_ / 2 : 0;
    step_.set_friction_share(friction_);
    check_stop();
  }
}

/// The two halves, and the whole for what they err by.
Attempt Implicit::try_step(double h) {
  Attempt made;
  runs_through_ = false;
  const auto arrives = [&](double reached) {
    made.event = std::max(reached + step_.arrival(), 0.01 * h);
    return made;
  };
  using Result = ImplicitStep::Result;
  Result result = step_.step(now_, h / 2, touching_, true, middle_);
  if (result == Result::arrives) return arrives(0);
  if (result == Result::failed || !step_.finish(middle_, touching_, true)) return made;
  // What arrives there ends a step.
  if (step_.jumped() && h > 4 * kConstants.shortest) {
    made.event = h / 2;
    return made;
  }
  result = step_.step(middle_, h / 2, touching_, true, end_);
  if (result == Result::arrives) return arrives(h / 2);
  if (result == Result::failed) return made;
  made.limit = 1;
  if (options_.step == 0) {
    const std::uint64_t pattern = end_.pattern();
    if (step_.step(now_, h, touching_, false, whole_) == Result::failed) return made;
    const bool same = pattern == whole_.pattern() && pattern == middle_.pattern();
    const double share = same ? std::exp2(kOrderOfHalves) - 1 : 1;
    const double time = std::min(velocity_time_of(length_), kWaves * h);
    const double raw = size(end_, whole_, time) / share;
    made.error = std::min(raw, step_.distance(end_, whole_, time) / share);
    made.limit = same ? allowed_error(h) : allowed_change();
    order_ = same ? kOrderOfHalves + 1 : 2;
    made.may_grow = same;  // steps without changes have a smaller limit
    made.error =
        std::max(made.error, raw * made.limit / (kConstants.passed_over * options_.tolerance));
    made.solved = !(made.error <= made.limit);
    if (made.solved) return made;
    if (same) step_.extrapolate(1 / (std::exp2(kOrderOfHalves) - 1), end_);
  }
  made.solved = step_.finish(end_, touching_, true);
  if (!made.solved) return made;
  if (const auto rope = step_.mechanism().run_through(end_.time, end_.state.data())) {
    if (h < kConstants.brief) {
      throw Diverged("direct", now_.time, counters_.steps, world_->connectors[*rope].name, 0,
                     kRunThrough);
    }
    made.solved = false;
    runs_through_ = true;
  }
  return made;
}

void Implicit::accept(double time) {
  end_.time = time;
  step_.accept();
  std::swap(from_, now_);
  std::swap(now_, end_);
  note_events();
  if (!now_.rate.empty()) rate_ = now_.rate;
  if (friction_ < 1) {
    friction_ = 1;
    step_.set_friction_share(friction_);
    jam_ *= 2;
  } else if (time - from_.time > kFades * jam_) {
    jam_ = std::max(jam_ / 2, kShortestJam);
  }
  step_.mechanism().follow(time, now_.state);
}

/// The events of the last step, which are told at its end.
void Implicit::note_events() {
  using Contact = StepState::Contact;
  const auto& rows = step_.mechanism().rows();
  const auto of_contact = [&](Event::Kind kind, std::uint32_t candidate, const Vec3& place,
                              double size) {
    const auto [one, other] = step_.touches().sides(candidate);
    events_.push_back({.kind = kind,
                       .time = now_.time,
                       .size = size,
                       .one = one,
                       .other = other,
                       .place = place,
                       .of_contact = true});
  };
  const auto of_link = [&](Event::Kind kind, std::size_t link, double size) {
    const ImplicitStep::Link& of = step_.links()[link];
    const auto& stretches = step_.mechanism().material().stretches();
    events_.push_back({.kind = kind,
                       .time = now_.time,
                       .connector = of.soft ? stretches[of.row].connector : rows[of.row].connector,
                       .span = of.soft ? stretches[of.row].link : rows[of.row].link,
                       .size = size});
  };
  for (std::size_t k = 0; k < now_.taut.size(); ++k) {
    const ImplicitStep::Link& link = step_.links()[k];
    const auto is_taut = [&](const StepState& at) {
      return link.soft_string ? at.tension[k] > 0 : at.taut[k] != 0;
    };
    if (is_taut(from_) == is_taut(now_)) continue;
    of_link(is_taut(now_) ? Event::Kind::taut : Event::Kind::slack, k, 0);
  }
  for (const StepState::Impulse& impulse : now_.impulses) {
    if (impulse.contact) {
      const bool touched =
          std::ranges::binary_search(from_.contacts, impulse.of, {}, &Contact::candidate);
      of_contact(touched ? Event::Kind::impulse : Event::Kind::hit, impulse.of, impulse.place,
                 impulse.size);
    } else {
      of_link(Event::Kind::impulse, impulse.of, impulse.size);
    }
  }
  if (from_.contacts.empty()) return;
  step_.touches().place(*world_, now_.time);
  for (const Contact& was : from_.contacts) {
    if (!was.presses) continue;
    const auto now =
        std::ranges::lower_bound(now_.contacts, was.candidate, {}, &Contact::candidate);
    const bool is_there = now != now_.contacts.end() && now->candidate == was.candidate;
    const auto tell = [&](Event::Kind kind) {
      const Meeting at = step_.touches().meet(step_.mechanism(), was.candidate, now_.state.data());
      of_contact(kind, was.candidate, step_.place_of(was.candidate, at, now_.state), 0);
    };
    if (!is_there || !now->presses) {
      tell(Event::Kind::leave);
    } else if (was.slip.isZero(0) != now->slip.isZero(0)) {
      tell(now->slip.isZero(0) ? Event::Kind::stick : Event::Kind::slide);
    }
  }
}

void Implicit::give_up(double time) {
  throw no_step(*world_, step_.mechanism(), now_.state.data(), time, counters_.steps);
}

}  // namespace taut::direct
