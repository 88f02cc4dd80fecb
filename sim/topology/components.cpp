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

namespace {

constexpr double kTaut = 1e-9;  // of the length: a span so near it is taut

SpanEnd span_end(const World& world, const Connector& connector, std::size_t particle,
                 const Hold* hold) {
  SpanEnd end;
  end.particle = particle;
  if (hold == nullptr) {
    const bool light = !(connector.particle_mass[particle] > 0);
    end.kind = light ? SpanEnd::Kind::follower : SpanEnd::Kind::particle;
    return end;
  }
  end.pin = hold->pin.number;
  if (!is_prescribed(world, hold->to)) {
    end.kind = SpanEnd::Kind::body;
    end.body = hold->to.body;
    end.point = hold->to.point;
  }
  return end;
}

Span make_span(const World& world, std::size_t c, std::size_t index, const SpanEnd& from,
               const SpanEnd& to, const std::vector<Span>& before) {
  const Connector& connector = world.connectors[c];
  Span span{c, index, from, to};
  for (std::size_t k = from.particle; k < to.particle; ++k) span.length += connector.rest[k];
  const double part = connector.length > 0 ? span.length / connector.length
                                           : static_cast<double>(span.links()) /
                                                 static_cast<double>(connector.links());
  span.mass = connector.mass * part;
  span.folds = span.links() > 1 || connector.model == ConnectorModel::span;
  const auto same = std::ranges::find_if(before, [&](const Span& old) {
    return old.connector == c && old.a.pin == from.pin && old.b.pin == to.pin &&
           old.length == span.length;
  });
  const Vec3 gap = connector.position[to.particle] - connector.position[from.particle];
  span.taut = same != before.end() ? same->taut : gap.norm() >= span.length * (1 - kTaut);
  return span;
}

}  // namespace

void divide(const World& world, const std::vector<Span>& before, std::vector<Span>& spans) {
  spans.clear();
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    const std::size_t last = connector.particles() - 1;
    SpanEnd from = span_end(world, connector, 0, nullptr);
    std::size_t index = 0;
    const auto close = [&](const SpanEnd& to) {
      if (to.particle > from.particle)
        spans.push_back(make_span(world, c, index++, from, to, before));
      from = to;
    };
    for (const Hold& hold : connector.holds)
      close(span_end(world, connector, hold.particle, &hold));
    if (from.particle < last) close(span_end(world, connector, last, nullptr));
  }
}

bool has_spans(const World& world) {
  return std::ranges::any_of(world.connectors,
                             [](const Connector& c) { return c.model == ConnectorModel::span; });
}

}  // namespace taut
