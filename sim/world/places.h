// Places along a connector, and particles that come and go there.
#pragma once

#include <span>

#include "sim/world/connector.h"

namespace taut {

constexpr double kSamePlace = 1e-9;  // of the length: places so near are one

/// A particle, or a place on the link behind it.
struct Place {
  std::size_t particle = 0;
  double fraction = 0;  // of the link from `particle` to the next; 0: at the particle
};

/// How far along a connector places were looked for: those behind cost no look at the links before.
struct Walk {
  std::size_t link = 0;
  double start = 0;  // m, of the link
};

/// The place at `along` (m from the first particle, of the connector's length), or the nearest end.
Place locate(const Connector& connector, double along);
/// The same for places that rise from call to call: none looks at the links before the last one.
Place locate(const Connector& connector, double along, Walk& walk);

/// Two places on a connector, and how far apart they can be: `most` is its length between them, and
/// `least` is above zero where one link, a rod, is longer than all others between them together.
struct DistanceRange {
  double least = 0, most = 0;  // m
};

/// The value at a place of what the particles have, such as positions.
Vec3 between(const std::vector<Vec3>& items, const Place& place);

/// Where the places at `along` (m, rising, and not before the walk) are; `from` is where the
/// connector begins on that scale.
std::vector<Vec3> positions(const Connector& connector, double from,
                            const std::vector<double>& along, Walk& walk);
/// How they move, m/s.
std::vector<Vec3> velocities(const Connector& connector, double from,
                             const std::vector<double>& along, Walk& walk);

/// True where something holds the particle.
bool holds(const Connector& connector, std::size_t particle);

/// The hold of the particle, or the place for it among the connector's holds.
std::vector<Hold>::iterator hold_at(Connector& connector, std::size_t particle);

/// The record of the pin for which the particle was added, or null.
PinRecord* added_for(Connector& connector, std::size_t particle);

/// Adds a particle without mass behind `place.particle`, where the link is now; its place on the
/// link is in the record.
PinRecord add_particle(Connector& connector, const Place& place);
/// The same for many places, which rise and lie on links; in one pass.
void add_particles(Connector& connector, std::span<const Place> places,
                   std::span<PinRecord> records);

/// Gives back what room the connector's arrays have beyond what is in them: methods make as much
/// for each of the parts that it may be divided into.
void fit(Connector& connector);

/// Removes particles, which rise, that were added for pins and whose holds are gone; in one pass.
/// Where no other such particle stands on a link, its rest length is what it was, bit by bit:
/// `link_rests` (m) are those of the links that they stand on.
void remove_particles(Connector& connector, std::span<const std::size_t> particles,
                      std::span<const double> link_rests);

}  // namespace taut
