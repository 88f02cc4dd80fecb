// The states of a simulation between its frames.
#pragma once

#include <vector>

#include "sim/run/simulation.h"

namespace taut {

/// The states of a simulation between two frames, by another simulation that stops more often. A
/// method that chooses its steps takes other steps with such stops: so the other simulation
/// restarts at every frame in the state of the first, and its difference at the next frame is taken
/// back evenly.
class Between {
 public:
  /// `other`: a simulation at its start, of the same world, method settings and timeline.
  explicit Between(Simulation other);

  /// The states at `times` (s, rising, between the two frames) of a simulation that was at `first`
  /// and is at `last` now. Throws as Simulation::advance_to() does; unusable after that.
  std::vector<Snapshot> states(const World& first, const std::vector<double>& times,
                               const Snapshot& last);

 private:
  Simulation simulation_;
};

}  // namespace taut
