// Draws a stage, a trajectory and characters' poses, at one instant or while a shutter is open.
#pragma once

#include <memory>
#include <span>

#include "render/draw/frame_state.h"
#include "render/draw/view.h"
#include "render/gl/canvas.h"
#include "render/gl/profile.h"
#include "scenes/scene/stage.h"
#include "sim/world/world.h"

namespace taut::draw {

/// A stage on the graphics side.
class StageRenderer {
 public:
  /// `world` tells what connectors hang on; its state does not matter. The stage must outlive this.
  StageRenderer(const gl::Context& context, const scenes::Stage& stage, const World& world,
                const Shading& shading = {});
  ~StageRenderer();

  /// Another background than the stage's from the next frame on.
  void set_background(const Vec3& color);

  /// Begins a frame: background everywhere, and the scenery in each of the views. The canvas
  /// keeps it for as long as the views stay the same.
  void begin(gl::Canvas& canvas, std::span<const View> views);
  /// Draws what moves into a part of the canvas, and its shadow on the scenery there.
  void draw(gl::Canvas& canvas, const picture::Rect& viewport, const FrameState& instant,
            const Layer& layer = {});
  /// The same while a shutter is open: `shutter` holds instants evenly apart, the frame's own in
  /// the middle (of an even number the later one). Parts that move less than a pixel are drawn
  /// once, at the frame's own instant; the rest each as often as its own speed asks for (jitter.h).
  /// The camera stands where it is in the middle. Returns how many exposures the fastest point
  /// took.
  int expose(gl::Canvas& canvas, const picture::Rect& viewport,
             std::span<const FrameState> shutter);

  /// Where to note the stages' times, each waited for; null: nowhere.
  void set_profile(gl::Profile* profile);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace taut::draw
