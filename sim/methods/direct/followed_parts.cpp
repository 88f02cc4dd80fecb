#include "sim/methods/direct/followed_parts.h"

#include <algorithm>
#include <stdexcept>

#include "sim/world/places.h"
#include "sim/world/room.h"

namespace taut::direct {
namespace {

std::size_t links_of(const Component& part) {
  std::size_t links = part.bodies.size();
  for (const SpanRange& span : part.spans) links += span.last - span.first;
  return links;
}

std::uint64_t pin_at(const Connector& connector, std::size_t particle) {
  const Hold* hold = find_hold(connector, particle);
  return hold ? hold->pin.number : 0;
}

template <typename Item>
void copy_range(const std::vector<Item>& from, std::size_t first, std::size_t last,
                std::vector<Item>& to) {
  to.assign(from.begin() + std::ptrdiff_t(first), from.begin() + std::ptrdiff_t(last));
}

/// A span whose ends are free or prescribed, as a world of its own.
World alone(const World& world, const SpanRange& span) {
  World part;
  part.time = world.time;
  part.gravity = world.gravity;
  Connector& piece = part.connectors.emplace_back();
  const Connector& whole = world.connectors[span.connector];
  copy_range(whole.position, span.first, span.last + 1, piece.position);
  copy_range(whole.velocity, span.first, span.last + 1, piece.velocity);
  copy_range(whole.particle_mass, span.first, span.last + 1, piece.particle_mass);
  copy_range(whole.rest, span.first, span.last, piece.rest);
  for (const std::size_t end : {span.first, span.last}) {
    const Hold* hold = find_hold(whole, end);
    if (!hold) continue;
    Hold& own = piece.holds.emplace_back(Hold{end - span.first, hold->to});
    if (own.to.kind != Attachment::Kind::body) continue;
    own.to.body = part.bodies.size();
    part.bodies.push_back(world.bodies[hold->to.body]);
  }
  return part;
}

}  // namespace

void FollowedParts::rebuild(const World& world) {
  const std::span<const Component> parts = division_.divide(world);
  if (integrators_.size() < parts.size()) make_room(world, parts);
  if (!changes_) align(parts);
  followed_ = parts.size();
  for (std::size_t k = 0; k < followed_; ++k) integrators_[k]->follow(parts[k]);
  known_.clear();
}

void FollowedParts::load(World& world) {
  place_held(world, world.time);
  // A particle that was pinned in motion leaves its neighbours so.
  if (changes_ || stretches(world)) velocity_projection_.stop(world);
  for (const auto& part : all()) part->load(world);
}

/// What integrators have grown to they keep: where one part has become two, all others stay with
/// theirs, and a new one gets the smaller half; where two have become one, that of the larger
/// goes on. So thousands of pins, one after another, take little more room than the longest part.
void FollowedParts::align(std::span<const Component> parts) {
  std::size_t first = 0;
  const auto same = [&](std::size_t k) { return links_of(parts[k]) == links_[k]; };
  while (first < std::min(links_.size(), parts.size()) && same(first)) ++first;
  const auto begin = integrators_.begin() + static_cast<std::ptrdiff_t>(first);
  if (parts.size() == links_.size() + 1) {
    const bool left =
        first + 1 == parts.size() || links_of(parts[first]) <= links_of(parts[first + 1]);
    const auto added = integrators_.begin() + static_cast<std::ptrdiff_t>(links_.size());
    std::rotate(left || begin == added ? begin : begin + 1, added, added + 1);
  } else if (parts.size() + 1 == links_.size()) {
    const bool left = first + 1 == links_.size() || links_[first] <= links_[first + 1];
    const auto spare = left ? begin : begin + 1;
    std::rotate(spare, spare + 1, integrators_.begin() + static_cast<std::ptrdiff_t>(followed_));
  }
  links_.clear();
  for (const Component& part : parts) links_.push_back(links_of(part));
}

/// Makes integrators for the parts, and for those into which the pins that the world has room for
/// can divide them.
void FollowedParts::make_room(const World& world, std::span<const Component> parts) {
  std::size_t largest = 0, spare = 0, pins = 0;  // links, particles
  for (const Component& part : parts) largest = std::max(largest, links_of(part));
  for (const Connector& connector : world.connectors) {
    spare += connector.position.capacity() - connector.particles();
    pins += connector.holds.capacity() - connector.holds.size();
  }
  changes_ = spare > 0;
  if (!changes_) pins = 0;  // nothing is meant to be added
  while (integrators_.size() < parts.size() + pins) {
    integrators_.push_back(std::make_unique<Integrator>(options_));
    if (changes_) integrators_.back()->reserve(largest + spare, 2 * (pins + 2));
  }
}

void FollowedParts::know(const World& world, std::span<const Component> parts) {
  known_.clear();
  distinct_ = true;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Component& part = parts[k];
    Key key{0, 0, ~std::uint64_t{0}};
    if (part.spans.empty()) {
      key[2] -= part.bodies[0];
    } else {
      const SpanRange& span = part.spans[0];
      const Connector& connector = world.connectors[span.connector];
      key = {pin_at(connector, span.first), pin_at(connector, span.last), 0};
      if (key[0] == 0 && key[1] == 0) key[2] = span.connector;
    }
    distinct_ = distinct_ && part.spans.size() <= 1;
    known_.push_back({key, k});
  }
  std::ranges::sort(known_, {}, &Known::key);
  distinct_ = distinct_ && std::ranges::adjacent_find(known_, {}, &Known::key) == known_.end();
}

bool FollowedParts::mark(const World& world, std::span<const Parts::Place> places) {
  if (known_.empty()) {
    std::vector<Component> parts;
    for (const auto& part : all()) parts.push_back(part->component());
    know(world, parts);
  }
  if (!distinct_) return false;
  marks_.assign(followed_, Mark::none);
  for (const Parts::Place& spot : places) {
    const Connector& connector = world.connectors[spot.connector];
    const auto [first, fraction] = locate(connector, spot.along);
    const std::size_t last = first + (fraction > 0 ? 1 : 0);
    // A cut takes the mass that these lack from farther off.
    const bool has_mass = connector.particle_mass[first] > 0 && connector.particle_mass[last] > 0;
    if (fraction > 0 && !has_mass) return false;
    for (std::size_t k = 0; k < followed_; ++k) {
      const Component& part = integrators_[k]->component();
      if (part.spans.empty() || part.spans[0].connector != spot.connector) continue;
      const SpanRange& span = part.spans[0];
      const bool has_spot = span.first <= first && last <= span.last;
      if (has_spot && !part.bodies.empty()) return false;
      if (has_spot) {
        marks_[k] = Mark::changed;
      } else if (!part.bodies.empty()) {
        marks_[k] = Mark::beside;  // what is in reach depends on them
      }
    }
  }
  return true;
}

void FollowedParts::renew(World& world) {
  const std::span<const Component> parts = division_.divide(world);
  if (integrators_.size() < parts.size()) make_room(world, parts);
  before_.swap(known_);
  know(world, parts);
  arranged_.clear();
  arranged_.resize(parts.size());
  auto old = before_.begin();
  std::size_t kept = 0;
  for (const Known& now : known_) {
    while (old != before_.end() && old->key < now.key) ++old;
    if (old == before_.end() || old->key != now.key) continue;
    if (marks_[old->part] == Mark::changed) continue;
    arranged_[now.part] = std::move(integrators_[old->part]);
    arranged_[now.part]->renumber(parts[now.part]);
    ++kept;
  }
  if (kept + std::size_t(std::ranges::count(marks_, Mark::changed)) != followed_) {
    throw std::logic_error("direct: something else was done than what was told");
  }
  place_prescribed(world, world.time);
  std::size_t part = 0;
  for (auto& spare : integrators_) {
    if (!spare) continue;
    while (part < parts.size() && arranged_[part]) ++part;
    if (part == parts.size()) {
      arranged_.push_back(std::move(spare));
      continue;
    }
    arranged_[part] = std::move(spare);
    arranged_[part]->follow(parts[part]);
    begin(world, *arranged_[part]);
  }
  integrators_.swap(arranged_);
  followed_ = parts.size();
  links_.clear();
  for (const Component& found : parts) links_.push_back(links_of(found));
}

/// Loads a part that is one span, whose ends may have been stopped in motion.
void FollowedParts::begin(World& world, Integrator& part) {
  const SpanRange& span = part.component().spans[0];
  World own = alone(world, span);
  if (stretches(own)) {
    velocity_projection_.stop(own);
    Connector& connector = world.connectors[span.connector];
    std::ranges::copy(own.connectors[0].velocity,
                      connector.velocity.begin() + std::ptrdiff_t(span.first));
  }
  part.load(world);
}

}  // namespace taut::direct
