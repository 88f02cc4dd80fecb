// The time that taut simulate takes, measured on a piece of the run.
#pragma once

#include <string>

#include "scenes/scene/scene.h"

namespace taut::cli {

struct RunTime {
  double seconds = 0;          // of CPU time, of the whole run; between the next two
  double least = 0, most = 0;  // by the average and by the last part of what was run
  double simulated = 0;        // s of the scene that were run to find it
  bool whole = false;          // that is all of the scene
  /// Too little was run to tell more than that it takes longer.
  bool at_least = false;
  std::string unknown;  // why nothing was run; empty: it was
};

/// Does what taut simulate does with the scene, for about a second of CPU time, in a copy of this
/// process, and tells the rest of the run from that. `started` (s) is the CPU time of
/// starting the program and reading the scene. Throws Interrupted.
RunTime time_of_run(const scenes::Scene& scene, double started);

/// As in "9.1 s, as its first 0.41 s tell".
std::string text_of(const RunTime& time);

}  // namespace taut::cli
