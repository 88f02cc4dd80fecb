// A cheaper method for a scene, as far as a piece of its run shows that the two agree.
#pragma once

#include <optional>
#include <string>

#include "render/cli/check_time.h"

namespace taut::cli {

struct Cheaper {
  MethodChoice method;
  double seconds = 0;  // of CPU time, of the whole run
  double apart = 0;    // m, at most: RMS of all particles and bodies at a frame
  double until = 0;    // s of the scene, as far as the two were compared
};

/// A method with which the run would take less than a twentieth of `time`, and whose states are no
/// more than 1% of the longest connector from those of the piece. `started` (s): as time_of_run()
/// takes it. `seconds`: CPU time to look for such a method.
std::optional<Cheaper> cheaper_method(const scenes::Scene& scene, const RunTime& time,
                                      double started, const Piece& piece, double seconds);

/// What to tell of it.
std::string text_of(const Cheaper& cheaper, const RunTime& time, const scenes::Scene& scene);

/// The settings that a run of more than a minute may be shortened with, as a sentence; or nothing.
std::string what_helps(const scenes::Scene& scene, const RunTime& time);

}  // namespace taut::cli
