// The time that taut simulate takes, measured on a piece of the run.
#pragma once

#include <string>

#include "render/cli/check_piece.h"

namespace taut::cli {

struct RunTime {
  double seconds = 0;          // of CPU time, of the whole run; between the next two
  double least = 0, most = 0;  // as parts of the piece tell
  double simulated = 0;        // s of the scene that were run to find it
  bool whole = false;          // that is all of the scene, or as far as it goes
  bool diverges = false;       // the run ends there by an error
  /// Too little was run to tell more than that it takes longer.
  bool at_least = false;
  std::string unknown;  // why nothing was run; empty: it was
};

/// Why no piece of the scene's run can be tried, or empty.
std::string why_not_tried(const scenes::Scene& scene);

/// What the whole run takes, as its piece tells. `started` (s) is the CPU time of starting the
/// program and reading the scene.
RunTime time_of_run(const scenes::Scene& scene, double started, const Piece& piece);

/// As in "9.1 s, as its first 0.41 s tell".
std::string text_of(const RunTime& time);

}  // namespace taut::cli
