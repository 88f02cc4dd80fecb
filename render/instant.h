// One moment of a scene as pictures need it.
#pragma once

#include <vector>

#include "scenes/stage.h"
#include "sim/trajectory.h"

namespace taut {

/// Everything that moves, at one time.
struct Instant {
  Snapshot state;
  std::vector<std::vector<Pose>> bones;  // [character][bone], world space
  CameraView camera;
};

/// Between two neighbouring instants, if everything goes straight and turns evenly meanwhile: the
/// first at `share` 0, the second at 1. The camera is the first's.
Instant between(const Instant& first, const Instant& second, double share);

/// What is drawn of an instant, and how.
struct Layer {
  bool characters = true, bodies = true, connectors = true;
  float opacity = 1;  // below 1: blended over what is there, casting no shadow
};

}  // namespace taut
