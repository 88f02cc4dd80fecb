// What runs are scored against: a converged solution at the frame times.
#pragma once

#include <vector>

#include "sim/run/trajectory.h"

namespace taut::study {

struct Reference {
  std::vector<Snapshot> frames;  // at Problem::times
  double horizon = 0;            // s; beyond it states cannot be compared, only invariants
  double self_error = 0;         // m, by how much two independent solutions differ until then
};

}  // namespace taut::study
