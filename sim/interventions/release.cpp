// Releasing pins.
#include <algorithm>
#include <utility>
#include <vector>

#include "sim/interventions/feasible.h"
#include "sim/interventions/interventions.h"
#include "sim/interventions/pinned.h"
#include "sim/links/projection.h"
#include "sim/topology/components.h"
#include "sim/world/places.h"

namespace taut {
namespace {

const Hold* find_in(std::span<const Hold> holds, std::size_t particle) {
  const auto hold = std::ranges::lower_bound(holds, particle, {}, &Hold::particle);
  return hold != holds.end() && hold->particle == particle ? &*hold : nullptr;
}

/// The span around a particle as it will be once what holds `released` (rising) is gone, and the
/// particles that were added for it.
JoinedSpan span_around(const Connector& connector, std::size_t particle,
                       std::span<const Hold> released) {
  const auto stays = [&](std::size_t i) { return holds(connector, i) && !find_in(released, i); };
  JoinedSpan span{particle, particle, 0, 0};
  while (span.first > 0 && !stays(span.first)) --span.first;
  while (span.last < connector.links() && !stays(span.last)) ++span.last;
  double link = 0;  // m, of what will be one
  for (std::size_t k = span.first; k < span.last; ++k) {
    span.length += connector.rest[k];
    link += connector.rest[k];
    const Hold* next = find_in(released, k + 1);
    if (next && next->pin.fraction > 0) continue;
    span.longest = std::max(span.longest, link);
    link = 0;
  }
  return span;
}

/// Marks all connectors and free bodies that are tied to those that are marked.
void mark_tied(const World& world, std::vector<char>& connectors, std::vector<char>& bodies) {
  bool more = true;
  const auto mark = [&](char& tied) { more |= std::exchange(tied, 1) == 0; };
  while (std::exchange(more, false)) {
    for (std::size_t c = 0; c < connectors.size(); ++c) {
      for (const Hold& hold : world.connectors[c].holds) {
        if (is_prescribed(world, hold.to)) continue;
        if (connectors[c]) mark(bodies[hold.to.body]);
        if (bodies[hold.to.body]) mark(connectors[c]);
      }
    }
    for (const Joint& joint : world.joints) {
      const bool any = std::ranges::any_of(joint.particles, [&](const Joint::Particle& at) {
        return connectors[at.connector] != 0;
      });
      for (const Joint::Particle& at : joint.particles) {
        if (any) mark(connectors[at.connector]);
      }
    }
    for (const Pulley& pulley : world.pulleys) {
      if (connectors[pulley.from]) mark(connectors[pulley.to]);
      if (connectors[pulley.to]) mark(connectors[pulley.from]);
    }
  }
}

/// restore_lengths() of everything tied to a connector: the rest may stand at an earlier time
/// (Islands).
void restore_tied(World& world, std::size_t connector) {
  std::vector<char> connectors(world.connectors.size(), 0), bodies(world.bodies.size(), 0);
  connectors[connector] = 1;
  mark_tied(world, connectors, bodies);
  World part;
  part.time = world.time;
  part.bodies = world.bodies;
  std::vector<std::size_t> own(connectors.size());  // index in the part
  for (std::size_t c = 0; c < connectors.size(); ++c) {
    if (!connectors[c]) continue;
    own[c] = part.connectors.size();
    part.connectors.push_back(world.connectors[c]);
  }
  for (const Joint& joint : world.joints) {
    if (!connectors[joint.particles[0].connector]) continue;
    for (Joint::Particle& at : part.joints.emplace_back(joint).particles) {
      at.connector = own[at.connector];
    }
  }
  for (const Pulley& pulley : world.pulleys) {
    if (!connectors[pulley.from]) continue;
    Pulley& made = part.pulleys.emplace_back(pulley);
    made.from = own[pulley.from];
    made.to = own[pulley.to];
  }
  if (!restore_lengths(part)) return;
  for (std::size_t c = 0; c < connectors.size(); ++c) {
    if (connectors[c]) world.connectors[c].position = part.connectors[own[c]].position;
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!bodies[b]) continue;
    world.bodies[b].position = part.bodies[b].position;
    world.bodies[b].rotation = part.bodies[b].rotation;
  }
}

}  // namespace

Outcome Interventions::release(World& world, std::uint64_t pin, std::size_t at) {
  ties_.follow(world);
  const auto [connector, h] = find_pin(world, pin, at);
  if (connector == nullptr) return Outcome::no_pin;
  released_.assign(1, connector->holds[h]);
  return drop(world, static_cast<std::size_t>(connector - world.connectors.data()));
}

Outcome Interventions::release(World& world, std::size_t index,
                               std::span<const std::uint64_t> pins) {
  if (index >= world.connectors.size()) return Outcome::no_connector;
  ties_.follow(world);
  std::vector<std::uint64_t> numbers(pins.begin(), pins.end());
  std::ranges::sort(numbers);
  released_.clear();
  for (const Hold& hold : world.connectors[index].holds) {
    const std::uint64_t number = hold.pin.number;
    if (number > 0 && std::ranges::binary_search(numbers, number)) released_.push_back(hold);
  }
  return released_.size() == pins.size() ? drop(world, index) : Outcome::no_pin;
}

/// Lets go the holds of the connector that are in released_.
Outcome Interventions::drop(World& world, std::size_t index) {
  Connector& connector = world.connectors[index];
  const auto left_links = [&](const Hold& hold) {  // that are not what they were before it
    return hold.pin.fraction > 0 && hold.pin.since != world.time && !connector.stretches() &&
           !connector.pulls;
  };
  bool needs_a_body = false;
  std::size_t seen = 0;
  for (const Hold& hold : released_) {
    if (!left_links(hold) || hold.particle < seen) continue;
    const JoinedSpan span = span_around(connector, hold.particle, released_);
    seen = span.last;
    const Joined joined = join(world, connector, span);
    if (joined == Joined::bent) return Outcome::too_near;
    needs_a_body |= joined == Joined::needs_a_body || !world.joints.empty();
  }
  const std::uint64_t topology = world.topology;
  world.topology -= structure_of_connector(world, index);
  std::erase_if(connector.holds,
                [&](const Hold& hold) { return find_in(released_, hold.particle); });
  gone_.clear();
  gone_from_.clear();
  for (const Hold& hold : released_) {
    let_go(world, index, hold.to);
    const PinRecord& record = hold.pin;
    if (record.since == world.time) {
      connector.position[hold.particle] = record.position;
      connector.velocity[hold.particle] = record.velocity;
      if (record.topology == topology && !is_prescribed(world, hold.to)) {
        Body& body = world.bodies[hold.to.body];
        body.position = record.body_position;
        body.velocity = record.body_velocity;
        body.spin = record.body_spin;
      }
    }
    if (record.fraction > 0) {
      gone_.push_back(hold.particle);
      gone_from_.push_back(record.link_rest);
    }
  }
  remove_particles(connector, gone_, gone_from_);
  ties_.particles_removed(world, index, gone_);
  std::size_t gone = 0;
  seen = 0;
  for (const Hold& hold : released_) {
    const std::size_t there = hold.particle - gone;
    if (hold.pin.fraction == 0) {
      ties_.place_joined(world, index, there);
      continue;
    }
    ++gone;
    if (needs_a_body || !left_links(hold) || there - 1 < seen) continue;
    seen = restorer_.restore(connector, there - 1);
  }
  if (needs_a_body) restore_tied(world, index);
  world.topology += structure_of_connector(world, index);
  ties_.followed(world);
  return Outcome::done;
}

}  // namespace taut
