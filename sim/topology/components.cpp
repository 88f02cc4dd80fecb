#include "sim/topology/components.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace taut {

Parts::Parts(std::span<const Connector> start) {
  for (std::size_t c = 0; c < start.size(); ++c) {
    parts_.push_back({c, c, 0, start[c].length});
    of_.push_back({{0, c}});
  }
}

/// Where two parts meet it is the older one.
std::size_t Parts::part(std::size_t whole, double along) const {
  const auto& row = of_.at(whole);
  const auto after = row.upper_bound(along);
  if (after == row.begin()) return whole;
  const auto found = std::prev(after);
  if (along > parts_[found->second].end) return whole;
  const bool shared = found != row.begin() && parts_[std::prev(found)->second].end == along;
  return shared ? std::min(found->second, std::prev(found)->second) : found->second;
}

Parts::Place Parts::at(std::size_t whole, double along) const {
  const Part& found = parts_[part(whole, along)];
  return {found.connector, along - found.start};
}

void Parts::cut(std::size_t whole, double along, std::size_t connector) {
  const std::size_t first = part(whole, along);
  of_.at(whole).emplace(along, parts_.size());
  parts_.push_back({whole, connector, along, parts_[first].end});
  parts_[first].end = along;
}

std::vector<std::size_t> Parts::in_a_row() const {
  std::vector<std::size_t> order;
  order.reserve(parts_.size());
  for (const auto& row : of_) {
    for (const auto& [start, part] : row) order.push_back(part);
  }
  return order;
}

std::size_t Division::find(std::size_t node) {
  while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
  return node;
}

void Division::reserve(const World& world) {
  std::size_t nodes = world.bodies.size() + world.connectors.size();
  for (const Connector& connector : world.connectors) nodes += connector.holds.size();
  if (nodes <= room_) return;
  room_ = world.bodies.size() + world.connectors.size() + room(world).holds;
  spans_.reserve(room_);
  sorted_spans_.reserve(room_);
  joints_.reserve(2 * room_);
  parent_.reserve(room_);
  index_.reserve(room_);
  sorted_bodies_.reserve(room_);
  parts_.reserve(room_);
  found_.reserve(room_);
}

void Division::collect(const World& world) {
  spans_.clear();
  joints_.clear();
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    each_span(world, c, [&](const SpanRange& span, const Hold* first, const Hold* last) {
      for (const Hold* hold : {first, last}) {
        if (hold && !is_prescribed(world, hold->to)) {
          joints_.push_back({spans_.size(), hold->to.body});
        }
      }
      spans_.push_back(span);
    });
  }
}

/// Numbers the parts in the order in which they are asked for.
std::size_t Division::part_of(std::size_t node) {
  std::size_t& part = index_[find(node)];
  if (part == index_.size()) {
    part = parts_.size();
    parts_.emplace_back();
  }
  return part;
}

std::span<const Component> Division::divide(const World& world) {
  reserve(world);
  collect(world);
  const std::size_t bodies = world.bodies.size(), nodes = bodies + spans_.size();
  parent_.resize(nodes);
  std::iota(parent_.begin(), parent_.end(), 0);
  for (const Joint& joint : joints_) parent_[find(bodies + joint.span)] = find(joint.body);
  index_.assign(nodes, nodes);
  parts_.clear();
  for (std::size_t s = 0; s < spans_.size(); ++s) ++parts_[part_of(bodies + s)].spans;
  const auto is_free = [&](std::size_t body) { return !world.bodies[body].driven(); };
  for (std::size_t b = 0; b < bodies; ++b) {
    if (is_free(b)) ++parts_[part_of(b)].bodies;
  }
  sorted_spans_.resize(spans_.size());
  sorted_bodies_.resize(bodies);
  found_.clear();
  SpanRange* span = sorted_spans_.data();
  std::size_t* body = sorted_bodies_.data();
  for (Part& part : parts_) {
    found_.push_back({{span, part.spans}, {body, part.bodies}});
    part.next_span = std::exchange(span, span + part.spans);
    part.next_body = std::exchange(body, body + part.bodies);
  }
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    *parts_[part_of(bodies + s)].next_span++ = spans_[s];
  }
  for (std::size_t b = 0; b < bodies; ++b) {
    if (is_free(b)) *parts_[part_of(b)].next_body++ = b;
  }
  return found_;
}

const Hold* find_hold(const Connector& connector, std::size_t particle) {
  const auto hold = std::ranges::lower_bound(connector.holds, particle, {}, &Hold::particle);
  return hold != connector.holds.end() && hold->particle == particle ? &*hold : nullptr;
}

bool move_as_one(const World& world, const Hold& a, const Hold& b) {
  if (is_prescribed(world, a.to)) return is_prescribed(world, b.to);
  return b.to.kind == Attachment::Kind::body && a.to.body == b.to.body;
}

}  // namespace taut
