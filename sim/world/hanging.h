// The catenary of a discrete chain, and links brought back to their lengths.
#pragma once

#include <span>
#include <vector>

#include "sim/world/connector.h"

namespace taut {

/// A chain that hangs at rest between two points. Keeps its memory from call to call.
class HangingChain {
 public:
  struct Links {
    std::span<const double> rest;           // m
    std::span<const double> particle_mass;  // kg, one more than links; unused without mass
    double length = 0;                      // m, of all links
    double mass = 0;                        // kg, of all particles; zero: all alike
  };
  /// Writes the particles, one more than links, from the first at `from` to the last at `to`, at
  /// most the length apart. Throws std::invalid_argument where there is no equilibrium.
  void place(const Links& links, const Vec3& from, const Vec3& to, const Vec3& gravity,
             std::span<Vec3> points);

 private:
  std::vector<double> before_;
};

// Bringing the links of a span back to their lengths.

/// Moves the particles of a span as little as restores its links, all masses counted: Newton's
/// method on the lengths, in linear time. Where an end is free one step of it, as little to first
/// order, after which the links are laid at their lengths. Keeps its workspace.
class LinkRestorer {
 public:
  /// Room for so many particles.
  void reserve(std::size_t particles) { rows_.reserve(particles); }

  /// Restores the span of the link, and tells its last particle; leaves the span as it is where
  /// that fails.
  std::size_t restore(Connector& connector, std::size_t link);

 private:
  struct Row {                   // a particle, and the link behind it
    Vec3 before = Vec3::Zero();  // m, where it was
    double inverse_mass = 0;     // 1/kg, zero where something holds it
    double squared = 0;          // m^2, of the link's length at rest
    Vec3 gap = Vec3::Zero();     // m, along the link
    // The link's multiplier, and what eliminating the one before left of its equation.
    double upper = 0, value = 0;
  };
  double measure(const Connector& connector, std::size_t first, std::size_t last);
  bool solve(std::size_t first, std::size_t last);

  std::vector<Row> rows_;
};

}  // namespace taut
