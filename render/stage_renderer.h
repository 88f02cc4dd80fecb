// Draws a stage at one instant: what a trajectory and the characters' poses look like.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "render/canvas.h"
#include "render/connector_mesh.h"
#include "render/profile.h"
#include "scenes/stage.h"
#include "sim/trajectory.h"
#include "sim/world.h"

namespace taut {

/// Everything that moves, at one time.
struct Instant {
  Snapshot state;
  std::vector<std::vector<Pose>> bones;  // [character][bone], world space
  CameraView camera;
};

/// A part of the canvas, and what is seen there.
struct View {
  Rect viewport;
  CameraView camera;
};

/// What is drawn of an instant, and how.
struct Layer {
  bool characters = true, bodies = true, connectors = true;
  float opacity = 1;  // below 1: blended over what is there, casting no shadow
};

/// What costs time and could be left out.
struct Shadows {
  int map_size = 1536;  // texels a side, of the key light's map
  bool contact = true;  // feet take ambient light from the floor
};

/// A stage on the graphics side.
class StageRenderer {
 public:
  /// `world` tells what connectors hang on; its state does not matter. The stage must outlive this.
  StageRenderer(const Context& context, const Stage& stage, const World& world,
                const Shadows& shadows = {});
  ~StageRenderer();

  /// Begins a frame: background everywhere, and the scenery in each of the views. The canvas
  /// keeps it for as long as the views stay the same.
  void begin(Canvas& canvas, std::span<const View> views);
  /// Draws what moves into a part of the canvas, and its shadow on the scenery there.
  void draw(Canvas& canvas, const Rect& viewport, const Instant& instant, const Layer& layer = {});

  /// Where to note the stages' times, each waited for; null: nowhere.
  void set_profile(Profile* profile);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace taut
