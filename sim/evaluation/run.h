// One run of one candidate on one problem: states at the frame times, cost, energy and stretch.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/run/cpu_time.h"
#include "sim/run/method_choice.h"
#include "sim/run/simulation.h"

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

}  // namespace taut::study
