// Cloth that hangs on a character: the skirt of the jacket, the cuffs and the belt's tails.
#pragma once

#include <vector>

#include "scenes/character/garment.h"

namespace taut::scenes {

/// All garments of a model; each may touch those before it.
class HangingCloth {
 public:
  /// None where the model has no bones for it.
  HangingCloth(const Model& model, const Skeleton& skeleton);

  /// Simulates all of it over [0, duration] (s), `rate` samples a second.
  void simulate(double duration, double rate, const Placed& placed);
  /// Turns the bones of all that hangs to where it has been simulated to be.
  void hang(double time, Placement& placed) const;

 private:
  std::vector<Garment> garments_;
  std::vector<Track> motions_;  // of those that have been simulated
};

}  // namespace taut::scenes
