#include "sim/world/places.h"

#include <algorithm>

namespace taut {
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

/// The particles' values, interpolated at the places `along`.
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
  PinRecord record;
  add_particles(connector, {&place, 1}, {&record, 1});
  return record;
}

void add_particles(Connector& connector, std::span<const Place> places,
                   std::span<PinRecord> records) {
  std::vector<Vec3>&position = connector.position, &velocity = connector.velocity;
  std::size_t before = places.size();  // how many of them lie before the particle
  std::size_t k = connector.links();
  const std::size_t particles = connector.particles() + before;
  position.resize(particles);
  velocity.resize(particles);
  connector.particle_mass.resize(particles);
  connector.rest.resize(particles - 1);
  const bool has_sections = !connector.sections.empty();
  if (has_sections) connector.sections.resize(particles - 1);
  while (before > 0) {  // from the last link on: what is not moved yet stays where it is
    position[k + before] = position[k];
    velocity[k + before] = velocity[k];
    connector.particle_mass[k + before] = connector.particle_mass[k];
    const std::size_t beyond = k-- + before;
    // On a link that pins divide already, fractions and rest length are those of the whole link.
    const PinRecord *start = nullptr, *end = nullptr;
    if (places[before - 1].particle == k) {
      start = added_for(connector, k);
      end = added_for(connector, k + 1);
    }
    const double rest = start ? start->link_rest : end ? end->link_rest : connector.rest[k];
    const double low = start ? start->fraction : 0;
    double high = end ? end->fraction : 1;
    const bool divided = places[before - 1].particle == k;
    for (; before > 0 && places[before - 1].particle == k; --before) {
      const double f = places[before - 1].fraction;
      PinRecord& record = records[before - 1];
      record.fraction = low + f * ((end ? end->fraction : 1) - low);
      record.link_rest = rest;
      const std::size_t added = k + before;
      position[added] = position[k] + f * (position[beyond] - position[k]);
      velocity[added] = velocity[k] + f * (velocity[beyond] - velocity[k]);
      connector.particle_mass[added] = 0;
      connector.rest[added] = (high - record.fraction) * rest;
      if (has_sections) connector.sections[added] = connector.sections[k];
      high = record.fraction;
    }
    connector.rest[k + before] = divided ? (high - low) * rest : connector.rest[k];
    if (has_sections) connector.sections[k + before] = connector.sections[k];
  }
  auto place = places.begin();
  for (Hold& hold : connector.holds) {
    while (place != places.end() && place->particle < hold.particle) ++place;
    hold.particle += static_cast<std::size_t>(place - places.begin());
  }
}

void fit(Connector& connector) {
  connector.holds.shrink_to_fit();
  connector.rest.shrink_to_fit();
  connector.sections.shrink_to_fit();
  connector.particle_mass.shrink_to_fit();
  connector.position.shrink_to_fit();
  connector.velocity.shrink_to_fit();
}

void remove_particles(Connector& connector, std::span<const std::size_t> particles,
                      std::span<const double> link_rests) {
  if (particles.empty()) return;
  // The links before each run of them become one with those behind it.
  for (std::size_t i = 0, end = 0; i < particles.size(); i = end) {
    for (end = i + 1; end < particles.size() && particles[end] == particles[end - 1] + 1; ++end) {
    }
    const PinRecord* before = added_for(connector, particles[i] - 1);
    const PinRecord* after = added_for(connector, particles[end - 1] + 1);
    const double low = before ? before->fraction : 0, high = after ? after->fraction : 1;
    connector.rest[particles[i] - 1] = (high - low) * link_rests[i];
  }
  const auto remove = [&](auto& items) {
    auto to = items.begin() + static_cast<std::ptrdiff_t>(particles[0]);
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const bool last = i + 1 == particles.size();
      const auto next =
          last ? items.end() : items.begin() + static_cast<std::ptrdiff_t>(particles[i + 1]);
      to = std::move(items.begin() + static_cast<std::ptrdiff_t>(particles[i]) + 1, next, to);
    }
    items.erase(to, items.end());
  };
  remove(connector.rest);
  if (!connector.sections.empty()) remove(connector.sections);
  remove(connector.position);
  remove(connector.velocity);
  remove(connector.particle_mass);
  auto removed = particles.begin();
  for (Hold& hold : connector.holds) {
    while (removed != particles.end() && *removed < hold.particle) ++removed;
    hold.particle -= static_cast<std::size_t>(removed - particles.begin());
  }
}

}  // namespace taut
