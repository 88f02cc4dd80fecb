// The whole physical state: bodies, connectors, gravity and the time; and what stands in their way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/motion/path.h"
#include "sim/motion/types.h"
#include "sim/world/body.h"
#include "sim/world/connector.h"
#include "sim/world/obstacle.h"

namespace taut {

// Where connectors are joined: particles that are one.

/// Particles of connectors that share their place and velocity; its mass is the sum of theirs. Two
/// of one connector close a loop. At most one of them is held.
struct Joint {
  struct Particle {
    std::size_t connector = 0, particle = 0;
  };
  std::vector<Particle> particles;  // at least two
};

/// The air that connectors with drag coefficients move through; the same everywhere.
struct Air {
  double density = 0;        // kg/m^3; zero: none
  Vec3 wind = Vec3::Zero();  // m/s
  /// Where it is in m, the wind is in m/s, beside `wind`. None: the wind is the same at all times.
  std::shared_ptr<const Path> gusts = nullptr;

  Vec3 wind_at(double time) const { return gusts ? Vec3(wind + gusts->at(time).position) : wind; }
};

/// A value: copying a world copies its state. Paths are shared. While a simulation runs, one may be
/// replaced in place (`*path = Path(...)`) by another that is the same until the world's time and
/// twice continuously differentiable there: so a hand can be moved live.
struct World {
  double time = 0;                   // s
  Vec3 gravity = Vec3(0, -9.81, 0);  // m/s^2
  Air air;
  std::vector<Body> bodies;
  std::vector<Connector> connectors;
  std::vector<Joint> joints;         // what joins connectors to each other and to themselves
  std::vector<Pulley> pulleys;       // where rope passes from one connector into another
  std::vector<Obstacle> obstacles;   // what beads of connectors and free bodies touch
  std::vector<BodyPair> pairs;       // of free bodies that touch each other
  std::vector<BeadPair> bead_pairs;  // of connectors and free bodies that do
  std::vector<ConnectorPair> connector_pairs;  // of connectors that do
  std::uint64_t topology = 0;    // another one whenever what structure() tells changes
  std::uint64_t pins = 0;        // how many there ever were
  std::uint32_t end_places = 0;  // the largest number of a Connector::end_place
};

/// Whether some connector stretches, resists bending or meets the air (Connector::sections).
bool has_materials(const World& world);

/// Whether anything touches: there are obstacles, or bodies or connectors that touch each other.
bool has_contact(const World& world);

/// Whether some connector has a winch or passes a pulley (Connector::winch).
bool has_winches(const World& world);

/// Whether links touch obstacles, not beads alone (Connector::links_touch).
bool has_touching_links(const World& world);
/// Whether some connector's links are strings (Connector::pulls).
bool has_strings(const World& world);

/// Whether some free body touches obstacles (Body::capsule), and there are some, or another body.
bool has_touching_bodies(const World& world);

}  // namespace taut
