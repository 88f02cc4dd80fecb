#include "sim/methods/direct/controller.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <utility>

#include "sim/material/forces.h"
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

namespace {

/// The share of the length below which slack, or what a fold leaves, is none: links turn by its
/// root, and their waves are as much quicker.
constexpr double kNone = 1e-3;

/// The least distance between two places on the connector: one link may be longer than all others
/// between them together.
double folded_length(const Connector& connector, std::size_t first, std::size_t last) {
  double length = 0, longest = 0;
  for (std::size_t i = first; i < last; ++i) {
    length += connector.rest[i];
    longest = std::max(longest, connector.rest[i]);
  }
  return 2 * longest - length;
}

double length_of(const Connector& connector, std::size_t first, std::size_t last) {
  const auto at = [&](std::size_t i) {
    return connector.rest.begin() + static_cast<std::ptrdiff_t>(i);
  };
  return std::accumulate(at(first), at(last), 0.0);
}

std::string full_length(const World& world, const SpanRange& span, double time) {
  const Connector& connector = world.connectors[span.connector];
  const Hold* from = find_hold(connector, span.first);
  const Hold* to = find_hold(connector, span.last);
  if (!from || !to || !is_prescribed(world, from->to) || !is_prescribed(world, to->to)) return {};
  const double length = length_of(connector, span.first, span.last);
  const PointMotion a = hold_motion(world, from->to, time), b = hold_motion(world, to->to, time);
  const Vec3 apart = b.position - a.position;
  const bool full = apart.norm() > (1 - kNone) * length;
  const bool folded =
      apart.norm() < folded_length(connector, span.first, span.last) + kNone * length;
  if (!full && !folded) return {};
  const double separation_speed = (b.velocity - a.velocity).dot(apart.normalized());  // m/s
  const double begin = length_of(connector, 0, span.first);
  std::ostringstream line;
  line << "the " << length << " m of it from " << begin << " m on are "
       << (full ? "at full length" : "folded") << " between two places that are held, "
       << apart.norm() << " m apart";
  if (full ? separation_speed > 0 : separation_speed < 0) {
    line << " and " << (full ? "parting" : "nearing") << " at " << std::abs(separation_speed)
         << " m/s: no motion keeps the length";
  } else {
    line << ": they stop there by an impulse that links without stretch leave open";
  }
  return line.str();
}

}  // namespace

std::string full_length(const World& world, const Component& part, double time) {
  for (const SpanRange& span : part.spans) {
    std::string why = full_length(world, span, time);
    if (!why.empty()) return why;
  }
  return {};
}

Diverged no_step(const World& world, const Mechanism& mechanism, const double* state, double time,
                 std::uint64_t steps) {
  const auto made = [&](std::size_t connector, std::size_t link, const std::string& why) {
    return Diverged("direct", time, steps, world.connectors[connector].name, link, why);
  };
  const auto& stretches = mechanism.material().stretches();
  if (const auto* pressed = material::pressed_together(stretches, state)) {
    return made(pressed->connector, pressed->link, material::kPressedTogether);
  }
  for (std::size_t c = 0, first = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    for (std::size_t k = 0; connector.pulls && k < connector.links(); ++k) {
      const Eigen::Map<const Vec3> from(state + mechanism.position(first + k)),
          to(state + mechanism.position(first + k + 1));
      if ((to - from).norm() < material::kShareOfNothing * connector.rest[k]) {
        return made(c, k,
                    "a link that only pulls is pressed together to nothing and has no "
                    "direction, expected links = \"rigid\" or no bending_stiffness");
      }
    }
    first += connector.particles();
  }
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const auto& holds = world.connectors[c].holds;
    for (std::size_t k = 1; !world.connectors[c].stretches() && k < holds.size(); ++k) {
      const SpanRange span{c, holds[k - 1].particle, holds[k].particle};
      const std::string why = full_length(world, span, time);
      if (!why.empty()) return made(c, span.first, why);
    }
  }
  std::size_t fastest = 0, link = 0, point = 0;
  double most = -1;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (std::size_t i = 0; i < world.connectors[c].particles(); ++i, ++point) {
      const double* v = state + mechanism.velocity(point);
      const double speed = std::hypot(v[0], v[1], v[2]);
      if (!(speed > most)) continue;
      most = speed;
      fastest = c;
      link = std::min(i, world.connectors[c].links() - 1);
    }
  }
  std::ostringstream why;
  why << "no step is small enough for the tolerance: ";
  if (mechanism.has_winches()) why << "a winch may take in what then whirls too fast, or ";
  why << "the links may be at their full length between what holds them; the fastest particle "
         "moves at "
      << std::max(most, 0.0) << " m/s";
  if (world.connectors.empty()) return {"direct", time, why.str()};
  return made(fastest, link, why.str());
}

std::optional<LedAway> led_away(const World& world) {
  constexpr double kRounding = 1e-6;  // of the connector's length
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    if (!connector.sections.empty()) continue;
    const bool may_be_slack = connector.model == ConnectorModel::span;
    const Hold* before = nullptr;
    for (const Hold& hold : connector.holds) {
      const bool known = is_prescribed(world, hold.to);
      const Hold* other = std::exchange(before, known ? &hold : nullptr);
      if (!known || !other) continue;
      if (!may_be_slack && hold.particle != other->particle + 1) continue;
      const std::size_t link = other->particle;
      const double length = length_of(connector, link, hold.particle);
      const double distance = (connector.position[hold.particle] - connector.position[link]).norm();
      const double off = may_be_slack ? distance - length : std::abs(distance - length);
      if (off <= kRounding * connector.length) continue;
      std::ostringstream line;
      line << "what holds both its ends leads them " << distance << " m apart, and it is " << length
           << " m long";
      return LedAway{c, link, line.str()};
    }
  }
  return {};
}

}  // namespace taut::direct
