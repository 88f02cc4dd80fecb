// The first piece of a run, in a copy of this process that is stopped when its time is over.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene/scene.h"

namespace taut::cli {

/// How far a run came.
struct Mark {
  double time = 0;  // s of the scene
  double cpu = 0;   // s, since the start of the run
};

struct Piece {
  std::vector<Mark> marks;       // rising; empty: not even the start was reached
  std::vector<Snapshot> states;  // at frames, as often as warnings look at them
  bool in_parts = false;         // the first frame took too long: the marks are within it
  double first_frame = 0;        // s of CPU time that did not suffice for it, then
  bool over = false;             // the run ends at the last mark, as `diverged` says
  std::string diverged;
  double unfinished = 0;  // s of CPU time behind the last mark
  double next = 0;        // s of the scene, from the last mark to the one that was not reached

  double until() const { return marks.empty() ? 0 : marks.back().time; }
};

/// The time (s) of the scene's last frame.
double end_of(const scenes::Scene& scene);

/// Does what taut simulate does with the scene, for `seconds` of CPU time at most.
Piece run_piece(const scenes::Scene& scene, double seconds);

}  // namespace taut::cli
