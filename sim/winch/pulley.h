// Where rope passes from one connector into another.
#pragma once

#include <cstddef>
#include <string>

namespace taut {

/// An eye or a sheave without size: the rope of the connector `from` leaves it at its last end and
/// enters `to` at its first. Both ends are held at one place (README.md).
struct Pulley {
  std::string name;
  std::size_t from = 0, to = 0;  // connectors
  double inertia = 0;            // kg: of a sheave about its axle, over the square of its radius
  double friction = 0;           // Coulomb's, of the rope on an eye
  double bearing = 0;  // Coulomb's, of a sheave's axle, times its radius over the sheave's
  bool has_friction() const { return friction > 0 || bearing > 0; }
  // The state.
  double passed = 0;  // m, since the start
  double speed = 0;   // m/s
};

}  // namespace taut
