#include "sim/methods/direct/contacts.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/contact/capsule.h"
#include "sim/topology/components.h"

namespace taut::direct {
namespace {

constexpr double kEndings = 60;  // 1/s, of times at which one looks at what is near
constexpr double kSurprise = 2;  // by how much speeds may rise until the next look

/// The node that stands for all that are joined with this one.
std::size_t find(std::vector<std::size_t>& parent, std::size_t node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

void copy_state(const Connector& from, Connector& to) {
  to.position = from.position;
  to.velocity = from.velocity;
}

void copy_state(const Body& from, Body& to) {
  to.position = from.position;
  to.rotation = from.rotation;
  to.velocity = from.velocity;
  to.spin = from.spin;
}

void copy_state(const World& from, World& to) {
  to.time = from.time;
  for (std::size_t b = 0; b < from.bodies.size(); ++b) copy_state(from.bodies[b], to.bodies[b]);
  for (std::size_t c = 0; c < from.connectors.size(); ++c) {
    copy_state(from.connectors[c], to.connectors[c]);
  }
}

bool same_state(const Body& a, const Body& b) {
  return a.position == b.position && a.rotation.coeffs() == b.rotation.coeffs() &&
         a.velocity == b.velocity && a.spin == b.spin;
}

contact::Capsule solid_of(const Body& body) {
  return {body.point(body.capsule.from), body.point(body.capsule.to), body.capsule.radius};
}

/// How far (m) a body's capsule reaches from its centre of mass.
double reach(const Body& body, const contact::Capsule& solid) {
  return std::max((solid.from - body.position).norm(), (solid.to - body.position).norm()) +
         solid.radius;
}

/// Whether a body may touch an obstacle within so many seconds of the part's present time.
bool is_body_near(const Body& body, const World& part, double within) {
  if (body.driven() || !body.capsule.touches()) return false;
  const contact::Capsule own = solid_of(body);
  const double radius = reach(body, own);
  for (const Obstacle& obstacle : part.obstacles) {
    if (!obstacle.touches(body.capsule.category)) continue;
    const FrameMotion frame = obstacle.frame(part.time);
    const double apart = contact::least_gap(obstacle.shape, frame.pose(), own);
    const double far = (body.position - frame.position).norm() + radius + std::max(apart, 0.0);
    const double speed = (body.velocity - frame.velocity).norm() + body.spin.norm() * radius +
                         frame.spin.norm() * far + part.gravity.norm() * within;
    if (apart <= kSurprise * speed * within) return true;
  }
  return false;
}

/// Whether two bodies may touch within so many seconds of the part's present time.
bool is_pair_near(const BodyPair& pair, const World& part, double within) {
  const Body &a = part.bodies[pair.a], &b = part.bodies[pair.b];
  const contact::Capsule own = solid_of(a), other = solid_of(b);
  const double speed = (a.velocity - b.velocity).norm() + a.spin.norm() * reach(a, own) +
                       b.spin.norm() * reach(b, other) + part.gravity.norm() * within;
  return contact::least_gap(other, own) <= kSurprise * speed * within;
}

/// Whether a bead may touch a body within so many seconds of the part's present time.
bool is_pair_near(const BeadPair& pair, const World& part, double within) {
  const Body& body = part.bodies[pair.body];
  const Connector& connector = part.connectors[pair.connector];
  const contact::Capsule solid = solid_of(body);
  const double radius = reach(body, solid);
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    const Vec3& at = connector.position[i];
    const double speed = (connector.velocity[i] - body.velocity).norm() +
                         body.spin.norm() * radius + part.gravity.norm() * within;
    const double near = kSurprise * speed * within;
    if ((at - body.position).norm() > radius + connector.radius + near) continue;
    if (contact::least_gap(solid, {at, at, connector.radius}) > near) continue;
    if (!find_hold(connector, i)) return true;
  }
  return false;
}

/// Whether a link may touch an obstacle within so many seconds of the part's present time.
bool is_link_near(const Connector& connector, const Obstacle& obstacle, const World& part,
                  double within) {
  const FrameMotion frame = obstacle.frame(part.time);
  for (std::size_t i = 0; i + 1 < connector.particles(); ++i) {
    const contact::Capsule own{connector.position[i], connector.position[i + 1], connector.radius};
    const double apart = contact::least_gap(obstacle.shape, frame.pose(), own);
    const auto speed = [&](std::size_t bead) {
      const double far = (connector.position[bead] - frame.position).norm() + std::max(apart, 0.0);
      return (connector.velocity[bead] - frame.velocity).norm() + frame.spin.norm() * far;
    };
    const double most = std::max(speed(i), speed(i + 1)) + part.gravity.norm() * within;
    if (apart <= kSurprise * most * within) return true;
  }
  return false;
}

}  // namespace

Contacts::Contacts(const StepOptions& options, std::function<std::unique_ptr<Method>()> make)
    : options_(options), make_(std::move(make)) {}

void Contacts::prepare(const World& world) {
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
  for (const BeadPair& pair : world.bead_pairs) {
    parent[find(parent, bodies + pair.connector)] = find(parent, pair.body);
  }
  for (const ConnectorPair& pair : world.connector_pairs) {
    parent[find(parent, bodies + pair.a)] = find(parent, bodies + pair.b);
  }
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
      BodyPair& own = part.pairs.emplace_back(pair);
      own.a = index_of(pair.a);
      own.b = index_of(pair.b);
    }
    for (const BeadPair& pair : world.bead_pairs) {
      if (!std::ranges::binary_search(made->bodies, pair.body)) continue;
      BeadPair& own = part.bead_pairs.emplace_back(pair);
      own.body = index_of(pair.body);
      const auto at = std::ranges::lower_bound(made->connectors, pair.connector);
      own.connector = static_cast<std::size_t>(at - made->connectors.begin());
    }
    for (const ConnectorPair& pair : world.connector_pairs) {
      if (!std::ranges::binary_search(made->connectors, pair.a)) continue;
      ConnectorPair& own = part.connector_pairs.emplace_back(pair);
      for (std::size_t* index : {&own.a, &own.b}) {
        const auto at = std::ranges::lower_bound(made->connectors, *index);
        *index = static_cast<std::size_t>(at - made->connectors.begin());
      }
    }
    made->near_links.rebuild(part);
    made->strings = has_strings(part);
    made->links = make_();
    made->implicit = std::make_unique<Implicit>(options_);
    made->now = part;
    made->now.pairs.clear();
    made->now.bead_pairs.clear();
    made->now.connector_pairs.clear();
    made->now.topology = structure(made->now);
    part.obstacles = world.obstacles;
    part.topology = structure(part);
    made->before = made->now;
    begin(*made);
  }
}

/// Copies the group's state; whether it has changed.
bool Contacts::read(const World& world, Group& group) {
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
    copy_state(from, to);
  }
  return changed;
}

void Contacts::write(const Group& group, World& world) {
  for (std::size_t i = 0; i < group.bodies.size(); ++i) {
    copy_state(group.part.bodies[i], world.bodies[group.bodies[i]]);
  }
  for (std::size_t i = 0; i < group.connectors.size(); ++i) {
    copy_state(group.part.connectors[i], world.connectors[group.connectors[i]]);
  }
}

/// Goes on from what the part shows.
void Contacts::begin(Group& group) {
  group.by_implicit = false;
  copy_state(group.part, group.now);
  group.time = group.end = group.part.time;
  group.stop = nullptr;
}

void Contacts::advance(World& world, double until, std::vector<Event>& events) {
  const auto first = static_cast<std::ptrdiff_t>(events.size());
  for (const auto& group : groups_) {
    if (read(world, *group)) begin(*group);
    follow(*group, until);
    show(*group, until);
    write(*group, world);
    for (const Event& event : group->events) {
      events.push_back(in_world(event, group->connectors, group->bodies));
    }
    group->events.clear();
  }
  std::stable_sort(events.begin() + first, events.end(),
                   [](const Event& one, const Event& other) { return one.time < other.time; });
  place_held(world, until);
}

/// Whether something of a group may touch something within so many seconds from there.
bool Contacts::is_near(Group& group, double within) {
  const World& part = group.part;
  const double fall = part.gravity.norm() * within;
  if (group.near_links.any()) {
    double fastest = 0;  // of two
    group.places.clear();
    for (const Connector& connector : part.connectors) {
      for (const Vec3& at : connector.position) {
        group.places.insert(group.places.end(), at.begin(), at.end());
      }
      for (const Vec3& velocity : connector.velocity) {
        fastest = std::max(fastest, 2 * velocity.norm());
      }
    }
    const double near = kSurprise * (fastest + 2 * fall) * within;
    if (group.near_links.is_any(group.places, near)) return true;
  }
  for (const Body& body : part.bodies) {
    if (is_body_near(body, part, within)) return true;
  }
  for (const BodyPair& pair : part.pairs) {
    if (is_pair_near(pair, part, within)) return true;
  }
  for (const BeadPair& pair : part.bead_pairs) {
    if (is_pair_near(pair, part, within)) return true;
  }
  for (const Obstacle& obstacle : part.obstacles) {
    const FrameMotion frame = obstacle.frame(part.time);
    for (const Connector& connector : part.connectors) {
      if (!obstacle.touches(connector.category)) continue;
      if (connector.links_touch && is_link_near(connector, obstacle, part, within)) return true;
      for (std::size_t i = 0; i < connector.particles(); ++i) {
        if (find_hold(connector, i)) continue;
        const Vec3& at = connector.position[i];
        const SurfaceDistance near = gap(obstacle, frame.pose(), at, connector.radius);
        const Vec3 surface =
            frame.velocity + frame.spin.cross(at - near.distance * near.normal - frame.position);
        const double speed = (connector.velocity[i] - surface).norm() + fall;
        if (near.distance <= kSurprise * speed * within) return true;
      }
    }
  }
  return false;
}

/// The next of the times (s) at which one looks at what is near: the same ones whatever is asked
/// for. They are those of frames, so that few of these are within a step.
double Contacts::next_end(double time) const {
  constexpr double kSliver = 1e-6;  // of the time between two
  const double rate = options_.step > 1 / kEndings ? 1 / options_.step : kEndings;
  return (std::floor(time * rate + kSliver) + 1) / rate;
}

/// Goes as far as `until` or beyond.
void Contacts::follow(Group& group, double until) const {
  if (group.stop && until >= group.time) std::rethrow_exception(group.stop);
  while (group.time < until) {
    if (group.time >= group.end) {
      group.end = next_end(group.time);
      group.by_implicit = false;
      if (!group.strings && follow_links(group, until)) continue;
      group.by_implicit = true;
    }
    follow_implicit(group, std::min(group.end, until));
  }
}

/// Follows what is near nothing as far as `end`; whether it was.
bool Contacts::follow_links(Group& group, double until) const {
  const double within = group.end - group.time;
  copy_state(group.now, group.part);
  if (is_near(group, within)) return false;
  copy_state(group.now, group.before);
  try {
    group.links->advance(group.now, group.end);
  } catch (const Diverged&) {  // perhaps not before what is asked for
    if (group.end <= until) throw;
    group.stop = std::current_exception();
  }
  if (!group.stop) {
    copy_state(group.now, group.part);
    if (is_near(group, within)) {
      copy_state(group.before, group.now);
      return false;
    }
  }
  group.time = group.end;
  return true;
}

void Contacts::follow_implicit(Group& group, double until) const {
  copy_state(group.now, group.part);
  try {
    group.implicit->advance(group.part, until, group.events);
  } catch (const Diverged& stop) {
    give_up(group.part, stop);
  }
  copy_state(group.part, group.now);
  group.time = until;
}

/// Shows the state at `until`, to which it has been followed.
void Contacts::show(Group& group, double until) const {
  if (until == group.time) {
    copy_state(group.now, group.part);
  } else {
    if (!group.shown_links) group.shown_links = make_();
    World shown = group.before;
    group.shown_links->advance(shown, until);
    copy_state(shown, group.part);
  }
}

/// Says why no step is possible. Bodies without a capsule touch nothing, nor do most links: they
/// may carry an end inside of an obstacle, or a cut make a bead there, farther than a link is long.
void Contacts::give_up(const World& part, const Diverged& stop) const {
  constexpr double kInside = 1e-6;  // of the connector's length
  for (const Obstacle& obstacle : part.obstacles) {
    const Pose frame = obstacle.frame(part.time).pose();
    for (const Connector& connector : part.connectors) {
      if (!obstacle.touches(connector.category)) continue;
      for (std::size_t i = 0; i < connector.particles(); ++i) {
        const bool held = find_hold(connector, i);
        const double radius = held ? 0 : connector.radius;
        const double apart = gap(obstacle, frame, connector.position[i], radius).distance;
        if (apart >= (held ? 0 : -kInside * connector.length)) continue;
        throw Diverged("direct", stop.time, counters_.steps, connector.name, i,
                       (held ? "an end is inside of obstacle " : "a bead is inside of obstacle ") +
                           obstacle.name);
      }
    }
  }
  throw Diverged(stop.method, stop.time, counters().steps, stop.connector, stop.link, stop.reason);
}

Counters Contacts::counters() const {
  Counters sum = counters_;
  for (const auto& group : groups_) {
    sum += group->implicit->counters();
    for (const auto* method : {&group->links, &group->shown_links}) {
      if (!*method) continue;
      sum += (*method)->counters();
    }
  }
  return sum;
}

}  // namespace taut::direct
