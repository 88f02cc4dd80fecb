#include "sim/methods/direct/followed_parts.h"

#include <algorithm>
#include <ranges>
#include <stdexcept>

#include "sim/topology/components.h"
#include "sim/world/places.h"

namespace taut::direct {
namespace {

std::size_t links_of(const Component& part) {
  std::size_t links = part.bodies.size();
  for (const SpanRange& span : part.spans) links += span.last - span.first;
  return links;
}

std::uint64_t pin_of(const Hold* hold) {
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
  const auto is_rigid = [&](const Component& part) {
    return part.spans.empty() || world.connectors[part.spans[0].connector].sections.empty();
  };
  auto parts = division_.divide(world) | std::views::filter(is_rigid);
  links_before_.swap(links_);
  links_.clear();
  for (const Component& part : parts) links_.push_back(links_of(part));
  if (integrators_.size() < links_.size()) make_room(world, links_.size());
  if (!changes_) align();
  followed_ = 0;
  for (const Component& part : parts) integrators_[followed_++]->follow(part);
  known_ = false;
}

void FollowedParts::load(World& world) {
  place_held(world, world.time);
  // A particle that was pinned in motion leaves its neighbours so.
  if (changes_ || stretches(world)) velocity_projection_.stop(world);
  for (const auto& part : all()) part->load(world);
}

/// Integrators keep the memory they have grown to: where one part has become two, all others stay
/// with theirs, and a new one gets the smaller half; where two have become one, that of the larger
/// goes on. So thousands of pins, one after another, take little more room than the longest part.
void FollowedParts::align() {
  const std::vector<std::size_t>& before = links_before_;
  const std::size_t first = std::size_t(std::ranges::mismatch(before, links_).in1 - before.begin());
  const auto begin = integrators_.begin() + static_cast<std::ptrdiff_t>(first);
  if (links_.size() == before.size() + 1) {
    const bool left = first + 1 == links_.size() || links_[first] <= links_[first + 1];
    const auto added = integrators_.begin() + static_cast<std::ptrdiff_t>(before.size());
    std::rotate(left || begin == added ? begin : begin + 1, added, added + 1);
  } else if (links_.size() + 1 == before.size()) {
    const bool left = first + 1 == before.size() || before[first] <= before[first + 1];
    const auto spare = left ? begin : begin + 1;
    std::rotate(spare, spare + 1, integrators_.begin() + static_cast<std::ptrdiff_t>(followed_));
  }
}

/// Makes integrators for so many parts, and for those into which the pins that the world has room
/// for can divide them.
void FollowedParts::make_room(const World& world, std::size_t parts) {
  std::size_t spare = 0, pins = 0;  // particles
  for (const Connector& connector : world.connectors) {
    spare += connector.position.capacity() - connector.particles();
    pins += connector.holds.capacity() - connector.holds.size();
  }
  const std::size_t largest = links_.empty() ? 0 : std::ranges::max(links_);
  changes_ = spare > 0 && double(parts + pins) * double(largest + spare) <= kMostRoom;
  if (!changes_) pins = 0;  // nothing is meant to be added, or too much
  while (integrators_.size() < parts + pins) {
    integrators_.push_back(std::make_unique<Integrator>(options_));
    if (changes_) integrators_.back()->reserve(largest + spare, 2 * (pins + 2));
  }
  links_.reserve(integrators_.size());
  links_before_.reserve(integrators_.size());
}

/// Where the part that is this piece is written down.
std::size_t& FollowedParts::entry(const Piece& piece) {
  if (piece.begin > 0) return begins_[piece.begin];
  if (piece.end > 0) return ends_[piece.end];
  return whole_[piece.span.connector];
}

/// The part that is this piece, or none.
std::size_t FollowedParts::find(const Piece& piece) {
  const std::size_t part = entry(piece);
  return part != kNone && pieces_[part].end == piece.end ? part : kNone;
}

void FollowedParts::enter(std::size_t part) {
  entry(pieces_[part]) = part;
  integrators_[part]->follow({{&pieces_[part].span, 1}, integrators_[part]->component().bodies});
}

void FollowedParts::know(const World& world) {
  known_ = distinct_ = true;
  pieces_.resize(integrators_.size());
  begins_.assign(world.pins + 1, kNone);
  ends_.assign(world.pins + 1, kNone);
  whole_.assign(world.connectors.size(), kNone);
  count_.assign(world.connectors.size(), 0);
  const auto pin_at = [&](const Connector& connector, std::size_t particle) {
    const std::uint64_t pin = pin_of(find_hold(connector, particle));
    const bool inside = particle > 0 && particle < connector.links();
    if (pin == 0 && inside) distinct_ = false;
    return pin;
  };
  for (std::size_t k = 0; k < followed_; ++k) {
    const Component& part = integrators_[k]->component();
    if (part.spans.size() > 1) distinct_ = false;
    if (part.spans.empty() || !distinct_) continue;
    const SpanRange& span = part.spans[0];
    const Connector& connector = world.connectors[span.connector];
    pieces_[k] = {span, pin_at(connector, span.first), pin_at(connector, span.last)};
    enter(k);
    ++count_[span.connector];
  }
}

bool FollowedParts::mark(const World& world, std::span<const Parts::Place> places) {
  if (!known_) know(world);
  if (!distinct_) return false;
  near_.clear();
  touched_.clear();
  for (const Parts::Place& spot : places) {
    const Connector& connector = world.connectors[spot.connector];
    const auto [first, fraction] = locate(connector, spot.along);
    const std::size_t last = first + (fraction > 0 ? 1 : 0);
    touched_.push_back(spot.connector);
    // The last hold up to the place, the first from it on, and where it is a hold, one farther.
    const auto& holds = connector.holds;
    const auto after = std::ranges::lower_bound(holds, last, {}, &Hold::particle);
    const bool is_hold = first == last && after != holds.end() && after->particle == first;
    const auto pin = [&](auto hold) { return hold == holds.end() ? 0 : hold->pin.number; };
    const auto before = [&](auto hold) { return hold == holds.begin() ? 0 : pin(hold - 1); };
    for (const Piece& piece : {Piece{{spot.connector}, before(after), pin(after)},
                               Piece{{spot.connector}, pin(after), is_hold ? pin(after + 1) : 0}}) {
      const std::size_t part = find(piece);
      if (part == kNone || std::ranges::count(near_, part) > 0) continue;
      const SpanRange& span = pieces_[part].span;
      if (span.connector != spot.connector || span.first > first || last > span.last) continue;
      if (!integrators_[part]->component().bodies.empty()) return false;
      near_.push_back(part);
    }
  }
  std::ranges::sort(touched_);
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
  return true;
}

void FollowedParts::renew(World& world) {
  begins_.resize(world.pins + 1, kNone);
  ends_.resize(world.pins + 1, kNone);
  for (std::size_t c = count_.size(); c < world.connectors.size(); ++c) touched_.push_back(c);
  whole_.resize(world.connectors.size(), kNone);
  count_.resize(world.connectors.size(), 0);
  for (const std::size_t part : near_) entry(pieces_[part]) = kNone;
  std::size_t before = near_.size();
  std::size_t there = 0, kept = near_.size();
  fresh_.clear();
  for (const std::size_t c : touched_) there += std::exchange(count_[c], 0);
  for (const std::size_t c : touched_) {
    each_span(world, c, [&](const SpanRange& span, const Hold* first, const Hold* last) {
      const Piece piece{span, pin_of(first), pin_of(last)};
      const std::size_t part = find(piece);
      ++count_[c];
      if (part == kNone) return fresh_.push_back(piece);
      pieces_[part].span = span;
      ++kept;
    });
  }
  if (kept != there) {
    throw std::logic_error("direct: something else was done than what was told");
  }
  for (const Piece& piece : fresh_) {
    std::size_t part = followed_;
    if (before > 0) {
      part = near_[--before];
    } else {
      // By an eighth, as each time all connectors are looked at.
      if (followed_ == integrators_.size()) make_room(world, followed_ + followed_ / 8 + 1);
      pieces_.resize(std::max(pieces_.size(), ++followed_));
      links_.push_back(0);
    }
    follow(world, part, piece);
  }
  std::ranges::sort(near_.begin(), near_.begin() + std::ptrdiff_t(before));
  while (before > 0) drop(near_[--before]);
}

/// Begins with a part that is one span, whose ends may have been stopped in motion.
void FollowedParts::follow(World& world, std::size_t part, const Piece& piece) {
  const SpanRange& span = piece.span;
  pieces_[part] = piece;
  links_[part] = span.last - span.first;
  entry(piece) = part;
  integrators_[part]->follow({{&pieces_[part].span, 1}, {}});
  World own = alone(world, span);
  if (stretches(own)) {
    velocity_projection_.stop(own);
    Connector& connector = world.connectors[span.connector];
    std::ranges::copy(own.connectors[0].velocity,
                      connector.velocity.begin() + std::ptrdiff_t(span.first));
  }
  integrators_[part]->load(world);
}

/// Follows this part no more; the last takes its index.
void FollowedParts::drop(std::size_t part) {
  const std::size_t last = --followed_;
  if (part != last) {
    integrators_[part].swap(integrators_[last]);
    links_[part] = links_[last];
    const Component& moved = integrators_[part]->component();
    if (!moved.spans.empty()) {
      pieces_[part] = pieces_[last];
      enter(part);
    }
  }
  links_.pop_back();
}

}  // namespace taut::direct
