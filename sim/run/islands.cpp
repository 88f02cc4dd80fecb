#include "sim/run/islands.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace taut {
namespace {

/// Sets that grow together.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  std::size_t find(std::size_t item) {
    while (parent_[item] != item) item = parent_[item] = parent_[parent_[item]];
    return item;
  }
  void join(std::size_t a, std::size_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::size_t> parent_;
};

bool on_free_body(const World& world, const Attachment& to) {
  return !is_prescribed(world, to);
}

/// The sets of tied members: first connectors, then bodies.
Sets tied(const World& world, const Timeline& timeline, std::span<const std::size_t> wholes) {
  const std::size_t bodies = world.connectors.size();  // where they begin
  Sets sets(bodies + world.bodies.size());
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (const Hold& hold : world.connectors[c].holds) {
      if (on_free_body(world, hold.to)) sets.join(c, bodies + hold.to.body);
    }
  }
  for (const Joint& joint : world.joints) {
    for (const Joint::Particle& at : joint.particles) {
      sets.join(joint.particles[0].connector, at.connector);
    }
  }
  for (std::size_t c = 0; c < wholes.size(); ++c) sets.join(c, wholes[c]);
  for (const Pulley& pulley : world.pulleys) sets.join(pulley.from, pulley.to);
  for (const BodyPair& pair : world.pairs) sets.join(bodies + pair.a, bodies + pair.b);
  for (const BeadPair& pair : world.bead_pairs) sets.join(pair.connector, bodies + pair.body);
  for (const ConnectorPair& pair : world.connector_pairs) sets.join(pair.a, pair.b);
  for (const TimedPin& pin : timeline.pins) {
    if (pin.to && on_free_body(world, *pin.to)) sets.join(pin.connector, bodies + pin.to->body);
  }
  return sets;
}

std::size_t index_of(const std::vector<std::size_t>& rising, std::size_t item) {
  return static_cast<std::size_t>(std::ranges::lower_bound(rising, item) - rising.begin());
}

void copy_state(const Connector& from, Connector& to) {
  std::ranges::copy(from.position, to.position.begin());
  std::ranges::copy(from.velocity, to.velocity.begin());
}

void copy_state(const Body& from, Body& to) {
  to.position = from.position;
  to.rotation = from.rotation;
  to.velocity = from.velocity;
  to.spin = from.spin;
}

}  // namespace

std::vector<std::size_t> island_numbers(const World& world, const Timeline& timeline,
                                        std::span<const std::size_t> wholes) {
  Sets sets = tied(world, timeline, wholes);
  std::vector<std::size_t> numbers(world.connectors.size() + world.bodies.size(), 0);
  std::size_t count = 0;
  const auto touch = [&](std::size_t connector) {
    std::size_t& number = numbers[sets.find(connector)];
    if (number == 0) number = ++count;
  };
  for (const TimedPin& pin : timeline.pins) touch(pin.connector);
  for (const TimedCut& cut : timeline.cuts) touch(cut.connector);
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < numbers.size(); ++i) found.push_back(numbers[sets.find(i)]);
  return found;
}

std::unique_ptr<Islands> Islands::find(const World& world, const Timeline& timeline,
                                       const Method& method, std::span<const std::size_t> wholes) {
  if (timeline.empty() || !method.again || !world.pulleys.empty()) return nullptr;
  const std::vector<std::size_t> numbers = island_numbers(world, timeline, wholes);
  const std::size_t connectors = world.connectors.size();
  std::unique_ptr<Islands> found(new Islands);
  found->islands_.resize(1 + std::ranges::max(numbers));
  found->island_of_.assign(numbers.begin(), numbers.begin() + std::ptrdiff_t(connectors));
  for (std::size_t c = 0; c < connectors; ++c) {
    found->islands_[numbers[c]].connectors.push_back(c);
  }
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    if (world.bodies[b].driven()) continue;
    found->islands_[numbers[connectors + b]].bodies.push_back(b);
  }
  for (std::size_t j = 0; j < world.joints.size(); ++j) {
    found->islands_[numbers[world.joints[j].particles[0].connector]].joints.push_back(j);
  }
  const Island& rest = found->islands_[0];
  if (rest.connectors.empty() && rest.bodies.empty() && found->islands_.size() == 2) return nullptr;
  found->again = found->again_ = method.again;
  found->called = method.called;
  found->step = method.step;
  for (Island& island : found->islands_) found->take(world, island);
  found->topology_ = world.topology;
  return found;
}

/// Makes the island's world out of the whole one, at its time.
void Islands::take(const World& whole, Island& island) {
  if (!island.method) island.method = again_();
  World& part = island.world;
  part.time = whole.time;
  part.gravity = whole.gravity;
  part.air = whole.air;
  part.obstacles = whole.obstacles;
  part.pins = whole.pins;
  // Driven bodies that hold it are a part of each island that they hold.
  for (const std::size_t c : island.connectors) {
    for (const Hold& hold : whole.connectors[c].holds) {
      if (hold.to.kind == Attachment::Kind::body) island.bodies.push_back(hold.to.body);
    }
  }
  std::ranges::sort(island.bodies);
  island.bodies.erase(std::unique(island.bodies.begin(), island.bodies.end()), island.bodies.end());
  part.bodies.clear();
  for (const std::size_t b : island.bodies) part.bodies.push_back(whole.bodies[b]);
  part.connectors.clear();
  for (const std::size_t c : island.connectors) {
    Connector& connector = part.connectors.emplace_back(whole.connectors[c]);
    for (Hold& hold : connector.holds) {
      if (hold.to.kind == Attachment::Kind::body) {
        hold.to.body = index_of(island.bodies, hold.to.body);
      }
    }
  }
  part.pairs.clear();
  for (const BodyPair& pair : whole.pairs) {
    if (!std::ranges::binary_search(island.bodies, pair.a)) continue;
    BodyPair& own = part.pairs.emplace_back(pair);
    own.a = index_of(island.bodies, pair.a);
    own.b = index_of(island.bodies, pair.b);
  }
  part.bead_pairs.clear();
  for (const BeadPair& pair : whole.bead_pairs) {
    if (!std::ranges::binary_search(island.bodies, pair.body)) continue;
    BeadPair& own = part.bead_pairs.emplace_back(pair);
    own.connector = index_of(island.connectors, pair.connector);
    own.body = index_of(island.bodies, pair.body);
  }
  part.connector_pairs.clear();
  for (const ConnectorPair& pair : whole.connector_pairs) {
    if (!std::ranges::binary_search(island.connectors, pair.a)) continue;
    ConnectorPair& own = part.connector_pairs.emplace_back(pair);
    own.a = index_of(island.connectors, pair.a);
    own.b = index_of(island.connectors, pair.b);
  }
  part.joints.clear();
  for (const std::size_t j : island.joints) {
    Joint& own = part.joints.emplace_back(whole.joints[j]);
    for (Joint::Particle& at : own.particles)
      at.connector = index_of(island.connectors, at.connector);
  }
  part.topology = structure(part);
}

/// Follows what has changed in the whole world since the last call.
void Islands::settle(const World& whole) {
  const std::size_t changed = std::exchange(changing_, kNone);
  if (whole.topology == topology_) return;
  if (changed != kNone) {
    for (std::size_t c = island_of_.size(); c < whole.connectors.size(); ++c) {
      island_of_.push_back(changed);
      islands_[changed].connectors.push_back(c);
    }
    take(whole, islands_[changed]);
  } else {
    // By somebody who told nobody what: it may be tied as it was not.
    islands_.clear();
    Island& all = islands_.emplace_back();
    all.connectors.resize(whole.connectors.size());
    std::iota(all.connectors.begin(), all.connectors.end(), 0);
    all.bodies.resize(whole.bodies.size());
    std::iota(all.bodies.begin(), all.bodies.end(), 0);
    all.joints.resize(whole.joints.size());
    std::iota(all.joints.begin(), all.joints.end(), 0);
    island_of_.assign(whole.connectors.size(), 0);
    take(whole, all);
    all.world.topology = whole.topology;
  }
  topology_ = whole.topology;
}

void Islands::add(const Counters& before, const Counters& after) {
  Counters done = after;
  done -= before;
  counters_ += done;
}

void Islands::advance(Island& island, World& whole, double until,
                      std::span<const Parts::Place> places) {
  if (island.connectors.empty() && island.bodies.empty()) return;  // the timeline does all
  World& part = island.world;
  part.gravity = whole.gravity;
  part.air = whole.air;
  for (std::size_t c = 0; c < island.connectors.size(); ++c) {
    copy_state(whole.connectors[island.connectors[c]], part.connectors[c]);
  }
  for (std::size_t b = 0; b < island.bodies.size(); ++b) {
    if (!part.bodies[b].driven()) copy_state(whole.bodies[island.bodies[b]], part.bodies[b]);
  }
  if (until > part.time || island.left_behind) {
    const Counters before = island.method->counters();
    try {
      std::vector<Parts::Place> own(places.begin(), places.end());
      for (Parts::Place& place : own)
        place.connector = index_of(island.connectors, place.connector);
      if (own.empty()) island.method->advance(part, until);
      island.left_behind = !own.empty() && island.method->advance_near(part, until, own);
    } catch (...) {
      add(before, island.method->counters());
      throw;
    }
    add(before, island.method->counters());
    for (const Event& event : island.method->events()) {
      events_.push_back(in_world(event, island.connectors, island.bodies));
    }
    island.method->clear_events();
  }
  for (std::size_t c = 0; c < island.connectors.size(); ++c) {
    copy_state(part.connectors[c], whole.connectors[island.connectors[c]]);
  }
  for (std::size_t b = 0; b < island.bodies.size(); ++b) {
    copy_state(part.bodies[b], whole.bodies[island.bodies[b]]);
  }
}

void Islands::advance(World& world, double until) {
  settle(world);
  for (Island& island : islands_) advance(island, world, until);
  place_prescribed(world, until);
  left_behind_ = false;
  std::ranges::stable_sort(
      events_, {}, [](const Event& event) { return std::pair(event.time, event.connector); });
}

void Islands::advance_island(World& world, double until, std::size_t connector,
                             std::span<const Parts::Place> places) {
  // A part that has just been cut off is of the same island.
  const bool same = connector >= island_of_.size() || island_of_[connector] == changing_;
  if (changing_ != kNone && same && world.time == until) return;
  settle(world);
  world.time = until;
  changing_ = island_of_[connector];
  advance(islands_[changing_], world, until, places);
  left_behind_ = true;
}

void Islands::tell(const Islands& other, void (*say)(Method& own, const Method& others)) {
  if (islands_.size() != other.islands_.size()) return;
  for (std::size_t i = 0; i < islands_.size(); ++i) {
    say(*islands_[i].method, *other.islands_[i].method);
  }
}

}  // namespace taut
