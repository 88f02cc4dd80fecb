// Steps of worlds with contact, and what is shown within them.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/contacts.h"
#include "sim/motion/stop.h"

namespace taut::direct {
namespace {

constexpr double kEndings = 60;                // 1/s, of times at which steps end
constexpr double kLongestStep = 1 / kEndings;  // s
constexpr double kShortestStep = 1e-8;         // s, below which a step cannot converge
constexpr double kFirstStep = 0.3;   // of the time in which gravity moves by the tolerance
constexpr double kFinest = 0.02;     // of that first step: errors force none that is shorter
constexpr double kTurn = 0.3;        // rad, of a link or an obstacle in a step
constexpr double kErrorShare = 0.3;  // of the tolerance, for what a second's steps err together
constexpr double kGain = 1e-2;       // s, in which speed from nowhere may err by the tolerance
constexpr double kGrowth = 1.3;      // of a step, at most
constexpr double kLowest = 0.1;      // of the tolerance: bounces and waves that are not followed
constexpr double kOver = 8;          // of the slippery steps, after which a jam fades
constexpr int kLocatedHits = 8;      // hits located in a row, before a step takes what it hits

}  // namespace

/// The next of the times (s) at which steps end, and one looks at what is near: the same ones
/// whatever is asked for. They are those of frames, so that few of these are within a step.
double Contacts::next_end(double time) const {
  constexpr double kSliver = 1e-6;  // of the time between two
  const double rate = options_.step > kLongestStep ? 1 / options_.step : kEndings;
  return (std::floor(time * rate + kSliver) + 1) / rate;
}

/// Steps as far as `until` or beyond.
void Contacts::follow(Group& group, double until) {
  if (group.stop && until >= group.time) std::rethrow_exception(group.stop);
  while (group.time < until) {
    if (group.time >= group.end) {
      group.end = next_end(group.time);
      group.by_implicit = false;
      if (!group.strings && follow_links(group, until)) continue;
      begin_implicit(group);
    }
    if (group.by_implicit) {
      follow_implicit(group, std::min(group.end, until));
      continue;
    }
    take_step(group, until);
  }
}

/// Follows what is near nothing as far as steps end; whether it was.
bool Contacts::follow_links(Group& group, double until) {
  const double within = group.end - group.time;
  if (group.steps) {
    return_to_present(group);
    group.step.store(group.now, group.time);
  }
  if (is_near(group, group.now, within)) return false;
  group.before = group.now;
  try {
    group.links->advance(group.now, group.end);
  } catch (const Diverged&) {  // perhaps not before what is asked for
    if (group.end <= until) throw;
    group.stop = std::current_exception();
  }
  if (!group.stop && is_near(group, group.now, within)) {
    group.now = group.before;
    return false;
  }
  group.steps = false;
  group.from = group.time;
  group.time = group.end;
  return true;
}

/// Hands the present state to Implicit, if the group has one.
void Contacts::begin_implicit(Group& group) {
  if (!group.implicit) return;
  if (group.steps) {
    return_to_present(group);
    group.step.store(group.now, group.time);
  }
  group.steps = false;
  group.by_implicit = true;
  group.before = group.now;
}

/// Follows a group by Implicit. Where it finds no step, ContactStep follows the group from where
/// Implicit began as far as steps end: so the times that are asked for change nothing.
void Contacts::follow_implicit(Group& group, double until) {
  const auto copy = [](const World& from, World& to) {
    to.time = from.time;
    to.bodies = from.bodies;
    for (std::size_t c = 0; c < from.connectors.size(); ++c) {
      to.connectors[c].position = from.connectors[c].position;
      to.connectors[c].velocity = from.connectors[c].velocity;
    }
  };
  copy(group.now, group.touching);
  try {
    group.implicit->advance(group.touching, until);
    copy(group.touching, group.now);
    group.from = group.time;
    group.time = until;
  } catch (const Diverged&) {
    group.by_implicit = false;
    group.now = group.before;
    group.time = group.now.time;
  }
}

/// Hands the present state to ContactStep.
void Contacts::begin_steps(Group& group) {
  if (group.h == 0) {
    const double gravity = std::max(group.now.gravity.norm(), 1.0);
    group.first = kFirstStep * std::sqrt(options_.tolerance / gravity);
    group.h =
        options_.step > 0 ? options_.step : std::min(kLongestStep / options_.finer, group.first);
  }
  place_held(group.now, group.time);
  group.step.load(group.now);
  group.from = group.time;
  group.time += group.step.resolve(group.time, kLowest * options_.tolerance);
  group.steps = true;
  group.is_noted = group.is_back = false;
}

/// A step of ContactStep.
void Contacts::take_step(Group& group, double until) {
  if (!group.steps) return begin_steps(group);
  return_to_present(group);
  ContactStep& step = group.step;
  double spin = 0;
  for (const Obstacle& obstacle : obstacles_) {
    spin = std::max(spin, obstacle.frame(group.time).spin.norm());
  }
  group.is_noted = std::min(group.time + group.h, group.end) > until;
  if (group.is_noted) step.note(group.before_step);
  group.located_before = group.located;
  group.slippery_before = group.slippery;
  for (;;) {
    const double left = group.end - group.time;
    const double stable = std::min(group.h, step.longest_damped());
    const double wish = spin > 0 ? std::min(stable, kTurn / spin) : stable;
    const double count = std::max(1.0, std::ceil(left / wish * (1 - 1e-9)));
    const double h = left / count;
    const double gone = attempt(group.step, group.time, h, group.slippery, group.located);
    if (fails(group, gone, h)) {
      ++counters_.rejected;
      group.h = group.limit = h / 2;
      if (group.h >= kShortestStep) continue;
      step.store(group.now, group.time);
      give_up(group.now, group);
    }
    step.accept();
    group.from = group.time;
    group.time = gone < h || count > 1 ? group.time + gone : group.end;
    group.located = gone < h ? group.located + 1 : 0;
    group.h = adapted(group, gone, wish);
    watch_jam(group, gone);
    if (step.snaps() && options_.step == 0) group.h = std::min(group.h, group.first);
    group.limit *= 2;
    group.h = std::min(group.h, group.limit);
    return;
  }
}

/// A step from `time` by at most h (s), after so many hits in a row.
double Contacts::attempt(ContactStep& step, double time, double h, double slippery, int located) {
  check_stop();
  const std::uint64_t before = step.solves();
  const double lowest = kLowest * options_.tolerance;
  const double gone = step.attempt(time, h, slippery, located < kLocatedHits, lowest);
  const std::uint64_t solves = step.solves() - before;
  ++counters_.steps;
  counters_.solves += solves;
  counters_.cycles += static_cast<double>(solves) *
                      (200 * static_cast<double>(step.mechanism().rows().size()) + 500);
  return gone;
}

/// Whether a step of h (s) that went so far has to be a shorter one.
bool Contacts::fails(const Group& group, double gone, double h) const {
  const ContactStep& step = group.step;
  if (gone == 0 || !(step.turn() <= kTurn)) return true;
  if (options_.step > 0 || !(h > kFinest * group.first)) return false;
  return step.error(kLowest * options_.tolerance) > 8 * kErrorShare * options_.tolerance * gone ||
         step.gained() * kGain > options_.tolerance;
}

/// The length of the next step after one of `gone` (s), where `wish` was allowed.
double Contacts::adapted(const Group& group, double gone, double wish) const {
  const ContactStep& step = group.step;
  double next = options_.step;
  if (next == 0) {
    const double error = step.error(kLowest * options_.tolerance);
    next = kGrowth * wish;
    // One that ended at a hit tells nothing of those that are longer than the first.
    if (group.located > 0) next = std::min(next, std::max(wish, group.first));
    if (error > 0) {
      next =
          std::min(next, 0.9 * gone * std::sqrt(kErrorShare * options_.tolerance * gone / error));
      next = std::max(next, gone / 2);
    }
    next = std::min(std::max(next, kFinest * group.first), kLongestStep / options_.finer);
  }
  return next;
}

/// A jam has no solution in shorter steps either, once the shortest have had none: as long as it
/// lasts, steps with less friction become longer from one to the next.
void Contacts::watch_jam(Group& group, double gone) {
  if (group.step.slips()) {
    group.slippery = std::max(group.slippery, 2 * gone);
    group.unjammed = 0;
  } else if ((group.unjammed += gone) > kOver * group.slippery) {
    group.slippery = std::max(group.slippery / 2, kShortestJam);
    group.unjammed = 0;
  }
}

/// Gives ContactStep the present state back, after it has shown another.
void Contacts::return_to_present(Group& group) {
  if (group.is_back) group.step.go_back(group.present);
  group.is_back = false;
}

/// Shows the state at `until`, to which it has been followed.
void Contacts::show(Group& group, double until) {
  World& part = group.part;
  if (part.time == until) return;
  if (group.steps && group.is_noted && until < group.time) return show_within_step(group, until);
  if (group.steps) {
    return_to_present(group);
    group.step.store(part, until);
  } else if (until == group.time) {
    part = group.now;
  } else {
    if (!group.shown_links) group.shown_links = make_();
    part = group.before;
    group.shown_links->advance(part, until);
  }
}

/// Shows the state at a time within the last step by shorter steps from its start: all lengths
/// hold, and nothing is inside of an obstacle. Where there is none, as far as they lead.
void Contacts::show_within_step(Group& group, double until) {
  ContactStep& step = group.step;
  if (!group.is_back) step.note(group.present);
  group.is_back = true;
  step.go_back(group.before_step);
  double time = group.from, longest = until - time;
  int located = group.located_before;
  while (time < until) {
    const double left = until - time, h = std::min(left, longest);
    const double gone = attempt(step, time, h, group.slippery_before, located);
    if (gone == 0) {
      longest = h / 2;
      if (longest < kShortestStep) break;
      continue;
    }
    step.accept();
    longest = 2 * h;
    located = gone < h ? located + 1 : 0;
    time = gone < left ? time + gone : until;
  }
  step.store(group.part, until);
}

}  // namespace taut::direct
