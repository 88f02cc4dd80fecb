// Draws a stage at one instant: what a trajectory and the characters' poses look like.
#pragma once

#include <map>
#include <memory>
#include <optional>
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

/// What is drawn of an instant, and how.
struct Layer {
  bool scenery = true, characters = true, bodies = true, connectors = true;
  float opacity = 1;  // below 1: blended over what is there, casting no shadow
};

/// A stage on the graphics side.
class StageRenderer {
 public:
  /// `world` tells what connectors hang on; its state does not matter. The stage must outlive this.
  StageRenderer(const Context& context, const Stage& stage, const World& world);
  ~StageRenderer();

  /// Fills the canvas with the background.
  void clear(const Canvas& canvas) const;
  /// Draws into a part of the canvas.
  void draw(const Canvas& canvas, const Rect& viewport, const Instant& instant,
            const Layer& layer = {});

  /// Where to note the stages' times, each waited for; null: nowhere.
  void set_profile(Profile* profile);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace taut
