// The reference solution of a world, as plans are proved against it: where everything is as long as
// that is predictable, and what every solution has in common after that.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"

namespace taut::study {

/// By how much a motion differs from the reference where neither is predictable.
struct Difference {
  /// A share of ReferenceSolution::energy_scale: of the energy, less the work of what drives it,
  /// the largest of any frame; of the mean over all frames where that work cannot be told
  /// (EnergyBalance).
  double energy = 0;
  double stretch = 0;  // the largest of a link, a share of its length
  double speeds = 0;   // of the distributions of all points' speeds, see distribution_distance()

  bool within(const Difference& most) const {
    return energy <= most.energy && stretch <= most.stretch && speeds <= most.speeds;
  }
};

struct ReferenceSolution {
  Problem problem;  // its times: as far as there is a solution
  SamplePoints sample_points;
  std::vector<std::vector<Vec3>> points = {};  // [frame][point], m
  bool closed = false;                         // nothing does work on it
  bool balanced = false;                       // it is known how much work is done
  std::vector<double> energy = {};             // J, of each frame, as EnergyBalance has it
  double energy_scale = 0;  // J, of lifting all by the length and of the most motion
  std::size_t known = 0;    // frames whose states can be compared
  double self_error = 0;    // m, by which solutions differ in these
  std::size_t checked = 0;  // of the known frames: by an independent solver
  // Of the frames from the last known one on:
  std::vector<double> speeds = {};  // m/s, rising
  double same_speed = 0;            // m/s: speeds that differ by less are equal
  Difference most = {};             // that a motion may differ

  /// The time (s) until which the motion is predictable.
  double horizon() const { return problem.times[known > 0 ? known - 1 : 0]; }
  /// True where it ends before the frames do.
  bool goes_on() const { return known < points.size(); }
};

/// Solves the problem for comparisons to within `scored_error` (m): by the direct method far more
/// finely; from two starts nudged by a ten-thousandth of that, to see how long the motion is
/// predictable and how much solutions differ later; and by the solver of the truth, which shares
/// neither its equations nor its integrators. What that cannot follow, or not with `most_cycles`
/// (see Counters::cycles), direct checks itself, ten times as finely. Calls `tick` after each frame
/// with the share of all that is done; it may throw. Throws Diverged where there is no second
/// frame, and OverLimit where a solution takes more than `cpu_cap` (s).
ReferenceSolution solve_reference(Problem problem, double scored_error, double most_cycles,
                                  const std::function<void(double)>& tick,
                                  double cpu_cap = std::numeric_limits<double>::infinity());

/// The same motion at other times (s, rising), as far as it is known; for comparisons of states
/// alone. Throws OverLimit where they take more than `cpu_cap` (s).
ReferenceSolution at_times(const ReferenceSolution& reference, double scored_error,
                           std::vector<double> times, const std::function<void(double)>& tick,
                           double cpu_cap = std::numeric_limits<double>::infinity());

// A run beside the reference solution: how far from it, and at what price.

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
