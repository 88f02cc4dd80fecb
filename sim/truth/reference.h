// The reference that runs are scored against: a converged solution at the frame times.
#pragma once

#include <vector>

#include "sim/run/trajectory.h"

namespace taut::truth {

struct Reference {
  std::vector<Snapshot> frames;
  /// Time (s) up to which errors may be scored. Of solve_truth(): until then a start nudged by a
  /// ten-thousandth of the scored error stays a hundred times closer to the truth than that error,
  /// and so does the second solution. Beyond it states are not predictable, and only invariants can
  /// be compared.
  double horizon = 0;
  /// The largest distance (m) of any particle between two independent solutions until then.
  double self_error = 0;
};

}  // namespace taut::truth
