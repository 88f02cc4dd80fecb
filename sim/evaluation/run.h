// One run of one candidate on one problem: states at the frame times, cost, energy and stretch.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/interventions/interventions.h"
#include "sim/motion/stop.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"
#include "sim/topology/components.h"
#include "sim/world/world.h"

namespace taut::study {

/// A problem to run: a world, the times (s, rising, from the world's own on) of its frames, and the
/// interventions.
struct Problem {
  World world;
  std::vector<double> times;
  Timeline timeline = {};

  double duration() const { return times.empty() ? 0 : times.back() - world.time; }
};

/// The times of `duration` seconds at `fps` frames a second, the first at zero and the last at the
/// end where a frame falls there; a clip's frames, by frame_count(), leave that one out.
std::vector<double> frame_times(double duration, int fps);

struct Run {
  enum class End { done, diverged, over_cap };
  End end = End::done;
  std::string reason;            // of an end that is not `done`
  std::vector<Snapshot> frames;  // at Problem::times, as far as the run came
  Counters counters;
  double cpu = 0;                // s, of stepping alone
  double reached = 0;            // s, the time of the last frame
  double failed_at = 0;          // s, where it diverged
  std::vector<double> stretch;   // of each frame, as stretch_max() has it
  double stretch_max = 0;        // of all frames
  double penetration_max = 0;    // m, of all frames, as contact::penetration_max() has it
  std::vector<double> energy;    // J, of each frame, above the energy at the start
  std::vector<double> momentum;  // kg m/s, of each frame: what gravity does not explain
  double energy_gain = 0;        // J, the most above the energy at the start, of all frames
  double energy_loss = 0;        // J, the most below it
};

/// The end as tables call it: done, diverged, over its CPU cap.
const char* text_of(Run::End end);

/// Runs `candidate` and records what Run holds. Stops once it has taken `cpu_cap` (s), within
/// a step too.
/// Settings must be valid: throws std::invalid_argument. Calls `tick`, where there is one, now and
/// then; it may throw.
Run run(const Problem& problem, const MethodChoice& candidate, double cpu_cap,
        const std::function<void()>& tick = {});

/// Runs `candidate` and records nothing: the CPU time (s) of stepping alone; where that is less
/// than 2 ms, the median of so many runs more. Throws Diverged.
double time_run(const Problem& problem, const MethodChoice& candidate);

// The settings of a method that sweeps go through.

/// Every combination of the values that the method offers to sweeps, the last setting fastest.
/// `thin`: of each number only the ends and the middle.
std::vector<MethodChoice> sweep(const MethodInfo& method, bool thin);

// The energy of a motion that nothing accounts for.

/// Follows a motion from frame to frame: by how much its energy differs from what it was after the
/// last intervention and what driven ends have added since.
///
/// The work of an end comes from momenta alone, whatever method moves the links: a part of mass M
/// and momentum P on one prescribed point h feels the force P' - M g there, so that its work is the
/// integral of h' . (P' - M g) = [h' . P] - M g . [h] - integral of h'' . P. Between frames the
/// centre of mass is taken for the cubic that has its places and velocities.
class EnergyBalance {
 public:
  explicit EnergyBalance(const Timeline& timeline);

  /// Goes on to the next frame, in which the world is so; the energy that is left over, J.
  double next(const World& world);

  /// False where something moved two points of one part, whose work momenta do not tell apart: then
  /// the work is in what is left over.
  bool complete() const { return complete_; }

  /// Whether a pin came, drew or went, or something was cut, between two times (s): each may change
  /// the energy, as mass moves to where a connector is cut.
  bool intervened(double from, double until) const;

 private:
  struct Interval {
    double from = 0, until = 0;  // s
  };
  struct Part {
    double mass = 0;                // kg
    Vec3 centre = Vec3::Zero();     // m
    Vec3 momentum = Vec3::Zero();   // kg m/s
    std::vector<Attachment> holds;  // whose motion is known beforehand
  };
  std::vector<Part> parts(const World& world);
  double work(const World& world, const Part& before, const Part& after, double from);

  Division division_;
  std::vector<Interval> interventions_;
  std::vector<Part> before_;
  bool begun_ = false, complete_ = true;
  double time_ = 0;   // s, of the last frame
  double level_ = 0;  // J: what the energy should be
};

}  // namespace taut::study
