// How fast the particles of a simulation's states are.
#pragma once

#include <vector>

#include "sim/run/simulation.h"

namespace taut {

/// The velocities of what Simulation::state() shows: the same particles of the same connectors,
/// whatever the timeline has pinned and cut so far.
class ShownVelocities {
 public:
  /// `start` and `timeline` are those that the simulation was made with.
  ShownVelocities(const World& start, const Timeline& timeline);

  /// [connector][particle], m/s.
  std::vector<std::vector<Vec3>> of(const Simulation& simulation) const;

 private:
  struct Shown {
    std::size_t whole = 0;      // the connector of the start that it is a part of
    std::vector<double> along;  // m on that, rising
  };
  std::vector<Connector> start_;
  std::vector<TimedCut> cuts_;  // in order of time
  std::vector<bool> shifted_;   // [connector of the start] a body stands before its first particle
  std::vector<Shown> shown_;
  std::vector<std::size_t> shown_row_;  // indices of them, as they follow each other
};

}  // namespace taut
