#include "sim/methods/direct/contacts.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/topology/components.h"

namespace taut::direct {
namespace {

constexpr double kSampling = 1.0 / 30;  // s, at most between two checks of what is near
constexpr double kLongest = 1.0 / 60;   // s, of a step
constexpr double kShortest = 1e-8;      // s, below which a step cannot converge
constexpr double kFirst = 0.3;          // of the time in which gravity moves by the tolerance
constexpr double kFinest = 0.02;        // of that first step: errors force none that is shorter
constexpr double kTurn = 0.3;           // rad, of a link or an obstacle in a step
constexpr double kShare = 0.3;          // of the tolerance, for what a second's steps err together
constexpr double kGain = 1e-2;          // s, in which speed from nowhere may err by the tolerance
constexpr double kGrowth = 1.3;         // of a step, at most
constexpr double kLowest = 0.1;         // of the tolerance: bounces and waves that are not followed
constexpr double kOver = 8;             // of the slippery steps, after which a jam fades
constexpr int kLocated = 8;             // hits located in a row, before a step takes what it hits

/// The node that stands for all that are joined with this one.
std::size_t find(std::vector<std::size_t>& parent, std::size_t node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

void copy_state(const World& from, std::size_t connector, Connector& to) {
  to.position = from.connectors[connector].position;
  to.velocity = from.connectors[connector].velocity;
}

void copy_state(const Body& from, Body& to) {
  to.position = from.position;
  to.rotation = from.rotation;
  to.velocity = from.velocity;
  to.spin = from.spin;
}

bool same_state(const Body& a, const Body& b) {
  return a.position == b.position && a.rotation.coeffs() == b.rotation.coeffs() &&
         a.velocity == b.velocity && a.spin == b.spin;
}

}  // namespace

/// Steps are of second order: finer ones are those of a tolerance that is lower by their square.
Contacts::Contacts(const StepOptions& options, std::function<std::unique_ptr<Method>()> make)
    : options_(options), make_(std::move(make)) {
  options_.tolerance /= options.finer * options.finer;
}

void Contacts::prepare(const World& world) {
  obstacles_ = world.obstacles;
  const std::size_t bodies = world.bodies.size();
  std::vector<std::size_t> parent(bodies + world.connectors.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto is_free = [&](std::size_t body) { return !world.bodies[body].driven(); };
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (const Hold& hold : world.connectors[c].holds) {
      if (hold.to.kind != Attachment::Kind::body || !is_free(hold.to.body)) continue;
      parent[find(parent, bodies + c)] = find(parent, hold.to.body);
    }
  }
  for (const BodyPair& pair : world.pairs) parent[find(parent, pair.a)] = find(parent, pair.b);
  counters_ = counters();
  groups_.clear();
  std::vector<std::size_t> group_of(parent.size(), parent.size());
  const auto group = [&](std::size_t node) -> Group& {
    std::size_t& index = group_of[find(parent, node)];
    if (index == parent.size()) {
      index = groups_.size();
      groups_.push_back(std::make_unique<Group>());
    }
    return *groups_[index];
  };
  for (std::size_t b = 0; b < bodies; ++b) {
    if (is_free(b)) group(b).bodies.push_back(b);
  }
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    Group& made = group(bodies + c);
    made.connectors.push_back(c);
    for (const Hold& hold : world.connectors[c].holds) {
      if (hold.to.kind == Attachment::Kind::body && !is_free(hold.to.body)) {
        made.bodies.push_back(hold.to.body);
      }
    }
  }
  for (const auto& made : groups_) {
    std::ranges::sort(made->bodies);
    made->bodies.erase(std::unique(made->bodies.begin(), made->bodies.end()), made->bodies.end());
    World& part = made->part;
    part.gravity = world.gravity;
    part.time = world.time;
    for (const std::size_t b : made->bodies) part.bodies.push_back(world.bodies[b]);
    for (const std::size_t c : made->connectors) {
      part.connectors.push_back(world.connectors[c]);
      for (Hold& hold : part.connectors.back().holds) {
        if (hold.to.kind != Attachment::Kind::body) continue;
        const auto at = std::ranges::lower_bound(made->bodies, hold.to.body);
        hold.to.body = static_cast<std::size_t>(at - made->bodies.begin());
      }
    }
    const auto index_of = [&](std::size_t body) {
      const auto at = std::ranges::lower_bound(made->bodies, body);
      return static_cast<std::size_t>(at - made->bodies.begin());
    };
    for (const BodyPair& pair : world.pairs) {
      if (!std::ranges::binary_search(made->bodies, pair.a)) continue;
      BodyPair& own = made->pairs.emplace_back(pair);
      own.a = index_of(pair.a);
      own.b = index_of(pair.b);
    }
    part.topology = structure(part);
    made->strings = has_strings(part);
    made->links = make_();
    made->step.rebuild(part, obstacles_, made->pairs);
  }
}

/// Copies the group's state; whether it has changed.
bool Contacts::read(const World& world, Group& group) const {
  bool changed = group.part.time != world.time;
  group.part.time = world.time;
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    const Body& from = world.bodies[group.bodies[i]];
    changed = changed || !same_state(from, group.part.bodies[i]);
    copy_state(from, group.part.bodies[i]);
  }
  for (std::size_t i = 0; i < group.connectors.size(); ++i) {
    const Connector& from = world.connectors[group.connectors[i]];
    Connector& to = group.part.connectors[i];
    changed = changed || from.position != to.position || from.velocity != to.velocity;
    copy_state(world, group.connectors[i], to);
  }
  return changed;
}

void Contacts::write(const Group& group, World& world) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    copy_state(group.part.bodies[i], world.bodies[group.bodies[i]]);
  }
  for (std::size_t i = 0; i < group.connectors.size(); ++i) {
    copy_state(group.part, i, world.connectors[group.connectors[i]]);
  }
}

void Contacts::advance(World& world, double until) {
  for (const auto& group : groups_) {
    if (read(world, *group)) group->steps = false;
    const double from = world.time;
    const auto checks = std::max(1.0, std::ceil((until - from) / kSampling - 1e-9));
    for (int check = 1; check <= checks; ++check) {
      follow(*group, check == checks ? until : from + (until - from) * check / checks);
    }
    write(*group, world);
  }
  place_held(world, until);
}

void Contacts::follow(Group& group, double until) {
  World& part = group.part;
  const double within = until - part.time;
  if (!group.strings && !is_near(group, within)) {
    group.before = part;
    group.links->advance(part, until);
    if (!is_near(group, within)) {
      group.steps = false;
      return;
    }
    part = group.before;
  }
  step_through(group, until);
}

/// Says why no step is possible. Bodies without a capsule touch nothing, nor do most links: they
/// may carry an end inside of an obstacle, or a cut make a bead there, farther than a link is long.
void Contacts::give_up(const Group& group) const {
  const World& part = group.part;
  constexpr double kInside = 1e-6;  // of the connector's length
  for (const Obstacle& obstacle : obstacles_) {
    const Pose frame = obstacle.frame(part.time).pose();
    for (const Connector& connector : part.connectors) {
      if (!obstacle.touches(connector.category)) continue;
      for (std::size_t i = 0; i < connector.particles(); ++i) {
        const bool held = find_hold(connector, i);
        const double radius = held ? 0 : connector.radius;
        const double apart = gap(obstacle, frame, connector.position[i], radius).distance;
        if (apart >= (held ? 0 : -kInside * connector.length)) continue;
        throw Diverged("direct", part.time, counters_.steps, connector.name, i,
                       (held ? "an end is inside of obstacle " : "a bead is inside of obstacle ") +
                           obstacle.name);
      }
    }
  }
  const std::string name = part.connectors.empty() ? part.bodies[0].name : part.connectors[0].name;
  const char* what = "no step of strings is small enough";
  if (!obstacles_.empty()) what = "no step at an obstacle is small enough";
  if (!group.pairs.empty()) what = "no step where bodies may touch is small enough";
  throw Diverged("direct", part.time, counters_.steps, name, 0, what);
}

void Contacts::step_through(Group& group, double until) {
  ContactStep& step = group.step;
  World& part = group.part;
  const double lowest = kLowest * options_.tolerance;
  if (group.h == 0) {
    group.first = kFirst * std::sqrt(options_.tolerance / std::max(part.gravity.norm(), 1.0));
    group.h = options_.step > 0 ? options_.step : std::min(kLongest / options_.finer, group.first);
  }
  double time = part.time;
  if (!group.steps) {
    place_held(part, time);
    step.load(part);
    time += step.resolve(time, lowest);
  }
  group.steps = true;
  double spin = 0;
  for (const Obstacle& obstacle : obstacles_) {
    spin = std::max(spin, obstacle.frame(time).spin.norm());
  }
  while (time < until) {
    const double left = until - time;
    double wish = group.h;
    if (spin > 0) wish = std::min(wish, kTurn / spin);
    const double count = std::ceil(left / wish * (1 - 1e-9));
    const double h = left / std::max(1.0, count);
    const std::uint64_t before = step.solves();
    const double gone = step.attempt(time, h, group.slippery, group.located < kLocated, lowest);
    ++counters_.steps;
    counters_.solves += step.solves() - before;
    counters_.cycles += static_cast<double>(step.solves() - before) *
                        (200 * static_cast<double>(step.mechanism().rows().size()) + 500);
    const bool judged = options_.step == 0 && h > kFinest * group.first;
    const double error = judged ? step.error(lowest) : 0;
    const bool gains = judged && step.gained() * kGain > options_.tolerance;
    const bool fails =
        gone == 0 || step.turn() > kTurn || error > 8 * kShare * options_.tolerance * gone || gains;
    if (fails) {
      ++counters_.rejected;
      group.h = group.limit = h / 2;
      if (group.h >= kShortest) continue;
      step.store(part, time);
      give_up(group);
    }
    step.accept();
    group.located = gone < h ? group.located + 1 : 0;
    time = gone < h || count > 1 ? time + gone : until;
    group.h = adapted(group, gone, wish);
    watch_jam(group, gone);
    if (step.snaps() && options_.step == 0) group.h = std::min(group.h, group.first);
    group.limit *= 2;
    group.h = std::min(group.h, group.limit);
  }
  step.store(part, until);
}

/// The length of the next step after one of `gone` (s), where `wish` was allowed.
double Contacts::adapted(const Group& group, double gone, double wish) const {
  const ContactStep& step = group.step;
  double next = options_.step;
  if (next == 0) {
    const double error = step.error(kLowest * options_.tolerance);
    next = kGrowth * wish;
    if (error > 0) {
      next = std::min(next, 0.9 * gone * std::sqrt(kShare * options_.tolerance * gone / error));
      next = std::max(next, gone / 2);
    }
    next = std::min(std::max(next, kFinest * group.first), kLongest / options_.finer);
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

Counters Contacts::counters() const {
  Counters sum = counters_;
  for (const auto& group : groups_) {
    const Counters& links = group->links->counters();
    sum.steps += links.steps;
    sum.solves += links.solves;
    sum.rejected += links.rejected;
    sum.handed_over += links.handed_over;
    sum.cycles += links.cycles;
  }
  return sum;
}

}  // namespace taut::direct
