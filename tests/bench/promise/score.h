// How well a method keeps its promise on a drawn scene.
#pragma once

#include "sim/run/method.h"
#include "tests/bench/promise/reference.h"

namespace taut::promise {

/// A scene run once.
struct Score {
  unsigned seed = 0;
  std::size_t kind = 0;
  std::size_t particles = 0;
  double ratio = 0;
  double tolerance = 0;   // of the length
  double error = 0;       // tolerances, infinite where the run ended before the horizon
  double estimate = 0;    // tolerances, what the run tells of that; not a number: nothing
  double estimating = 0;  // what that cost, in costs of the run
  double horizon = 0;     // s
  double growth = 0;      // nudges
  double solves = 0, rejected = 0;
  double ms = 0;  // CPU, per simulated second
  bool diverged = false;

  /// The estimate, in errors; one where both are zero.
  double told() const { return estimate == error ? 1 : estimate / error; }
};

/// The factor within which an estimate should be right.
constexpr double kNear = 3;
inline bool near(const Score& score) {
  return score.told() <= kNear && score.told() >= 1 / kNear;
}

/// Runs the scene for all of its duration with the candidate's `tolerance` set to `asked` times
/// that share of the length. The error is the largest of all frames up to the horizon, each the RMS
/// over all particles.
Score score(const Drawn& drawn, const Reference& reference, MethodChoice candidate,
            double tolerance, double asked, double cap);

/// Runs it again, up to the horizon, and sets what the run estimates of its own error.
void add_estimate(Score& score, const Drawn& drawn, const Reference& reference,
                  MethodChoice candidate, double asked);

}  // namespace taut::promise
