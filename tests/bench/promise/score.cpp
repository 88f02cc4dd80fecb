#include "tests/bench/promise/score.h"

#include <algorithm>
#include <limits>

#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/run/error_estimate.h"

namespace taut::promise {
namespace {

double apart(const Vec3& a, const Vec3& b, double) {
  return (a - b).norm();
}

double largest(const study::Run& run, const Reference& reference) {
  if (run.frames.size() < reference.frames.size()) return std::numeric_limits<double>::infinity();
  double error = 0;
  for (std::size_t k = 0; k < reference.frames.size(); ++k) {
    error = std::max(error, study::frame_error(run.frames[k], reference.frames[k], apart));
  }
  return error;
}

}  // namespace

Score score(const Drawn& drawn, const Reference& reference, MethodChoice candidate,
            double tolerance, double asked, double cap) {
  const double allowed = tolerance * drawn.length;
  candidate.settings["tolerance"] = asked * allowed;
  const study::Run result =
      study::run({drawn.world, study::frame_times(kDuration, kFps)}, candidate, cap);
  Score score;
  score.seed = drawn.seed;
  score.kind = drawn.kind;
  score.particles = drawn.particles;
  score.ratio = drawn.ratio;
  score.tolerance = tolerance;
  score.error = largest(result, reference) / allowed;
  score.horizon = reference.horizon();
  score.growth = reference.growth;
  const double simulated = result.reached > 0 ? result.reached : 1;
  score.solves = static_cast<double>(result.counters.solves) / simulated;
  score.rejected = static_cast<double>(result.counters.rejected) / simulated;
  score.ms = 1e3 * result.cpu / simulated;
  score.diverged = result.end == study::Run::End::diverged;
  return score;
}

void add_estimate(Score& score, const Drawn& drawn, const Reference& reference,
                  MethodChoice candidate, double asked) {
  const double allowed = score.tolerance * drawn.length;
  candidate.settings["tolerance"] = asked * allowed;
  Simulation simulation(drawn.world, make_method(candidate.name, candidate.settings));
  ErrorEstimate estimate(drawn.world, candidate.name, candidate.settings);
  double stepping = 0, following = 0;  // s of CPU time
  try {
    for (const Snapshot& frame : reference.frames) {
      const double start = thread_seconds();
      simulation.advance_to(frame.time);
      const double middle = thread_seconds();
      estimate.follow(simulation);
      following += thread_seconds() - middle;
      stepping += middle - start;
    }
  } catch (const Diverged&) {
    score.estimate = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  score.estimate = estimate.largest() / allowed;
  score.estimating = following / stepping;
}

}  // namespace taut::promise
