// A run beside the reference solution: how far from it, and at what price.
#pragma once

#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/energy_balance.h"
#include "sim/evaluation/reference_solution.h"
#include "sim/evaluation/statistics.h"

namespace taut::study {

/// Goes from frame to frame of the reference solution, with any world that has the same connectors
/// and bodies, whatever chain of particles stands for a connector.
class ComparedRun {
 public:
  /// `reference` and `distance` must outlive it. Throws std::invalid_argument where the method does
  /// not take the settings.
  ComparedRun(const ReferenceSolution& reference, const World& world, const Timeline& timeline,
              const MethodChoice& candidate, const Distance& distance);

  /// To the next frame; false where there is none. Throws Diverged.
  bool next();

  /// The largest distance of any point so far, in the frames that can be compared; infinite where
  /// one is not finite.
  double error() const { return error_; }
  /// The differences in the frames after the horizon so far; of speeds, and of the mean energy
  /// where the work is not known, only after the last frame.
  Difference later() const;
  /// Of the solves so far.
  double cycles() const;
  const Simulation& simulation() const { return simulation_; }

 private:
  const ReferenceSolution& reference_;
  const Distance& distance_;
  Simulation simulation_;
  SamplePoints sample_points_;
  std::size_t frame_ = 0;  // the next one
  double error_ = 0;
  double stretch_ = 0;  // after the horizon
  EnergyBalance balance_;
  EnergyDifference energy_;
  Speeds speeds_;
};

}  // namespace taut::study
