#include "sim/methods/direct/contacts.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/topology/components.h"

namespace taut::direct {
namespace {

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
    : given_(options), options_(options), make_(std::move(make)) {
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
  for (const BeadPair& pair : world.bead_pairs) {
    parent[find(parent, bodies + pair.connector)] = find(parent, pair.body);
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
      BodyPair& own = made->pairs.emplace_back(pair);
      own.a = index_of(pair.a);
      own.b = index_of(pair.b);
    }
    for (const BeadPair& pair : world.bead_pairs) {
      if (!std::ranges::binary_search(made->bodies, pair.body)) continue;
      BeadPair& own = made->bead_pairs.emplace_back(pair);
      own.body = index_of(pair.body);
      const auto at = std::ranges::lower_bound(made->connectors, pair.connector);
      own.connector = static_cast<std::size_t>(at - made->connectors.begin());
    }
    part.topology = structure(part);
    made->strings = has_strings(part);
    made->links = make_();
    made->step.rebuild(part, obstacles_, made->pairs, made->bead_pairs);
    make_implicit(world, *made);
    begin(*made);
  }
}

/// Sets up Implicit where there is friction, or bodies touch each other.
void Contacts::make_implicit(const World& world, Group& group) const {
  World& touching = group.touching = group.part;
  touching.obstacles = world.obstacles;
  touching.pairs = group.pairs;
  touching.bead_pairs = group.bead_pairs;
  touching.topology = structure(touching);
  const Features used = features(touching);
  const bool is_rough = used.has(Feature::friction) || used.has(Feature::body_pairs);
  if (is_rough && given_.step == 0) {
    group.implicit = std::make_unique<Implicit>(given_);
  } else {
    touching = {};
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

/// Goes on from what the part shows.
void Contacts::begin(Group& group) {
  group.steps = group.is_noted = group.is_back = group.by_implicit = false;
  group.now = group.part;
  group.from = group.time = group.end = group.part.time;
  group.stop = nullptr;
}

void Contacts::advance(World& world, double until) {
  for (const auto& group : groups_) {
    if (read(world, *group)) begin(*group);
    follow(*group, until);
    show(*group, until);
    write(*group, world);
  }
  place_held(world, until);
}

/// Says why no step is possible. Bodies without a capsule touch nothing, nor do most links: they
/// may carry an end inside of an obstacle, or a cut make a bead there, farther than a link is long.
void Contacts::give_up(const World& part, const Group& group) const {
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
  const bool bodies_touch = !group.pairs.empty() || !group.bead_pairs.empty();
  if (bodies_touch) what = "no step where bodies may touch is small enough";
  throw Diverged("direct", part.time, counters_.steps, name, 0, what);
}

Counters Contacts::counters() const {
  Counters sum = counters_;
  for (const auto& group : groups_) {
    if (group->implicit) sum += group->implicit->counters();
    for (const auto* method : {&group->links, &group->shown_links}) {
      if (!*method) continue;
      sum += (*method)->counters();
    }
  }
  return sum;
}

}  // namespace taut::direct
