// Points by which motions are compared, whatever chain of particles stands for the connector.
#pragma once

#include <vector>

#include "sim/run/trajectory.h"
#include "sim/world/world.h"

namespace taut::study {

/// The material points of one world: every particle of its connectors, and of each body the ends of
/// the box with its mass and inertia (for a stick, the ends of the stick).
class SamplePoints {
 public:
  /// `start`: the state at the beginning, from which lengths along the connectors are taken.
  SamplePoints(const World& world, const Snapshot& start);

  /// Where the sample points of `of` are in a state of this world (m). Connectors and bodies must
  /// be those of `of`; a connector may have another number of particles, between which its links
  /// are straight.
  std::vector<Vec3> places(const SamplePoints& of, const Snapshot& state) const;

 private:
  std::vector<std::vector<double>> along_;  // [connector][particle], share of the length
  std::vector<std::vector<Vec3>> ends_;     // [body], m, body frame
};

}  // namespace taut::study
