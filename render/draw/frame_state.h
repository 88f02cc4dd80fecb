// An instant of a scene as pictures need it.
#pragma once

#include <vector>

#include "scenes/scene/stage.h"
#include "sim/run/trajectory.h"

namespace taut::draw {

/// Everything that moves, at one time.
struct FrameState {
  Snapshot state;
  std::vector<std::vector<Pose>> bones;  // [character][bone], world space
  scenes::CameraView camera;
  std::vector<scenes::TrailPoints> trails = {};  // of the stage; the frame's own instant has them
};

/// The parts of an instant to draw, and how.
struct Layer {
  bool characters = true, bodies = true, connectors = true;
  float opacity = 1;  // below 1: blended over what is there, casting no shadow
  bool shadow = true;
};

}  // namespace taut::draw
