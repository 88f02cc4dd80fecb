// The catenary of a discrete chain.
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

}  // namespace taut
