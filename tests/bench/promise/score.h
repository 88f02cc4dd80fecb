// How well a method keeps its promise on a drawn scene.
#pragma once

#include "sim/study/candidate.h"
#include "tests/bench/promise/reference.h"

namespace taut::promise {

/// A scene run once.
struct Score {
  unsigned seed = 0;
  std::size_t kind = 0;
  std::size_t particles = 0;
  double ratio = 0;
  double tolerance = 0;  // of the length
  double error = 0;      // tolerances, infinite where the run ended before the horizon
  double horizon = 0;    // s
  double growth = 0;     // nudges
  double solves = 0, rejected = 0;
  double ms = 0;  // CPU, per simulated second
  bool diverged = false;
};

/// Runs the scene for all of its duration with the candidate's `tolerance` set to that share of the
/// length. The error is the largest of all frames up to the horizon, each the RMS over all
/// particles.
Score score(const Drawn& drawn, const Reference& reference, Candidate candidate, double tolerance,
            double cap);

}  // namespace taut::promise
