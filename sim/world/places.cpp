#include "sim/world/places.h"

#include <algorithm>

namespace taut {
namespace {

template <typename T>
void insert_at(std::vector<T>& items, std::size_t index, const T& item) {
  items.insert(items.begin() + static_cast<std::ptrdiff_t>(index), item);
}

template <typename T>
void erase_at(std::vector<T>& items, std::size_t index) {
  items.erase(items.begin() + static_cast<std::ptrdiff_t>(index));
}

}  // namespace

Place locate(const Connector& connector, double along) {
  Walk walk;
  return locate(connector, along, walk);
}

Place locate(const Connector& connector, double along, Walk& walk) {
  const double same = kSamePlace * connector.length;
  for (auto& [k, start] = walk; k < connector.links(); ++k) {
    const double rest = connector.rest[k];
    if (along <= start + same) return {k, 0};
    if (along < start + rest - same) return {k, (along - start) / rest};
    start += rest;
  }
  return {connector.links(), 0};
}

Vec3 between(const std::vector<Vec3>& items, const Place& place) {
  const auto [k, f] = place;
  return f > 0 ? Vec3(items[k] + f * (items[k + 1] - items[k])) : items[k];
}

namespace {

/// What the particles have, at the places at `along`.
std::vector<Vec3> values(const Connector& connector, const std::vector<Vec3>& items, double from,
                         const std::vector<double>& along, Walk& walk) {
  std::vector<Vec3> found;
  found.reserve(along.size());
  for (const double place : along) {
    found.push_back(between(items, locate(connector, place - from, walk)));
  }
  return found;
}

}  // namespace

std::vector<Vec3> positions(const Connector& connector, double from,
                            const std::vector<double>& along, Walk& walk) {
  return values(connector, connector.position, from, along, walk);
}

std::vector<Vec3> velocities(const Connector& connector, double from,
                             const std::vector<double>& along, Walk& walk) {
  return values(connector, connector.velocity, from, along, walk);
}

bool holds(const Connector& connector, std::size_t particle) {
  return std::ranges::binary_search(connector.holds, particle, {}, &Hold::particle);
}

std::vector<Hold>::iterator hold_at(Connector& connector, std::size_t particle) {
  return std::ranges::lower_bound(connector.holds, particle, {}, &Hold::particle);
}

PinRecord* added_for(Connector& connector, std::size_t particle) {
  const auto hold = hold_at(connector, particle);
  const bool there = hold != connector.holds.end() && hold->particle == particle;
  return there && hold->pin.fraction > 0 ? &hold->pin : nullptr;
}

PinRecord add_particle(Connector& connector, const Place& place) {
  const std::size_t k = place.particle, added = k + 1;
  const double f = place.fraction;
  // On a link that pins divide already, fractions and rest length are those of the whole link.
  const PinRecord *before = added_for(connector, k), *after = added_for(connector, k + 1);
  const double low = before ? before->fraction : 0, high = after ? after->fraction : 1;
  PinRecord record;
  record.fraction = low + f * (high - low);
  record.link_rest = before ? before->link_rest : after ? after->link_rest : connector.rest[k];
  insert_at(connector.position, added, between(connector.position, place));
  insert_at(connector.velocity, added, between(connector.velocity, place));
  insert_at(connector.particle_mass, added, 0.0);
  connector.rest[k] = (record.fraction - low) * record.link_rest;
  insert_at(connector.rest, added, (high - record.fraction) * record.link_rest);
  if (!connector.sections.empty()) {
    insert_at(connector.sections, added, Section(connector.sections[k]));
  }
  for (Hold& hold : connector.holds) hold.particle += hold.particle > k;
  return record;
}

void fit(Connector& connector) {
  connector.holds.shrink_to_fit();
  connector.rest.shrink_to_fit();
  connector.sections.shrink_to_fit();
  connector.particle_mass.shrink_to_fit();
  connector.position.shrink_to_fit();
  connector.velocity.shrink_to_fit();
}

void remove_particle(Connector& connector, std::size_t particle, double link_rest) {
  const PinRecord* before = added_for(connector, particle - 1);
  const PinRecord* after = added_for(connector, particle + 1);
  const double low = before ? before->fraction : 0, high = after ? after->fraction : 1;
  connector.rest[particle - 1] = (high - low) * link_rest;
  erase_at(connector.rest, particle);
  if (!connector.sections.empty()) erase_at(connector.sections, particle);
  erase_at(connector.position, particle);
  erase_at(connector.velocity, particle);
  erase_at(connector.particle_mass, particle);
  for (Hold& hold : connector.holds) hold.particle -= hold.particle > particle;
}

}  // namespace taut
