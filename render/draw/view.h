// A view of a stage: its camera, its place in the picture, and the savings of its drawing.
#pragma once

#include <vector>

#include "render/picture/picture.h"
#include "scenes/scene/stage.h"
#include "sim/run/trajectory.h"

namespace taut::draw {

/// A part of the canvas, and what is seen there.
struct View {
  picture::Rect viewport;
  scenes::CameraView camera;
};

/// The savings of a picture. None of them shows: `all` and `exposures` make the same picture,
/// within one step of 8 bits where more exposures than samples are added up. `none` shows slow
/// things at more times, and so smears them more smoothly.
enum class Savings {
  all,        // kept backdrops, scissors, and triangles that are skipped or drawn once for all
  exposures,  // slow things take fewer exposures than fast ones; all is drawn whole in each
  none,       // everything is drawn whole in as many exposures as the fastest thing takes
};

/// Work that could be left out.
struct Shading {
  int map_size = 3072;  // texels a side, of the key light's map
  bool contact = true;  // feet take ambient light from the floor
  bool lit = true;      // false: one colour everywhere, what triangles and samples alone cost
  Savings savings = Savings::all;
  double still = 1;  // px that a thing may move while the shutter is open, and be drawn once
};

// An instant of a scene as pictures need it.

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
