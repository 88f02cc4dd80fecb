// Draws a stage, a trajectory and characters' poses, at one instant or while a shutter is open.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "render/draw/motion_extents.h"
#include "render/draw/stage_parts.h"
#include "render/draw/view.h"
#include "render/gl/canvas.h"
#include "render/gl/gpu.h"
#include "scenes/scene/stage.h"
#include "sim/world/world.h"

namespace taut::draw {

// Pictures of a stage without any saving, for the others to be compared with: every triangle is
// drawn over the whole picture, in every exposure.

/// Draws the moving parts at one instant, and their shadows on the scenery.
void draw_whole(StageParts& parts, gl::Canvas& canvas, const picture::Rect& viewport,
                const FrameState& instant, const Layer& layer);

/// The same while a shutter is open, each triangle at the exposures of its grades.
void expose_whole(StageParts& parts, gl::Canvas& canvas, const picture::Rect& viewport,
                  std::span<const FrameState> shutter, std::span<const Exposures> grades,
                  const MotionExtents& extents);

/// The same with everything in each of `count` exposures.
void expose_whole(StageParts& parts, gl::Canvas& canvas, const picture::Rect& viewport,
                  std::span<const FrameState> shutter, int count);

// Lower bounds of the time of a frame's stages.

/// Floors of stages, from what this machine can do.
class StageFloor {
 public:
  /// Measures how fast one core copies memory: some hundredths of a second.
  StageFloor(int width, int height, int samples);

  /// CPU time (s) below which a stage cannot come: of one that draws lit surfaces, what the same
  /// triangles and samples take in one colour (`unlit`, the profile of such frames); of one that
  /// moves pixels, its bytes at the speed of copying. None where neither is known.
  std::optional<double> of(std::string_view stage, const gl::Profile& unlit) const;

 private:
  double pixels_, samples_;
  double speed_;  // B/s, read and written together
};

/// A stage on the graphics side.
class StageRenderer {
 public:
  /// `world` tells what connectors hang on; its state does not matter. The stage must outlive this.
  StageRenderer(const gl::Context& context, const scenes::Stage& stage, const World& world,
                const Shading& shading = {});
  ~StageRenderer();

  /// Another background than the stage's from the next frame on.
  void set_background(const Vec3& color);
  /// What is drawn from the next frame on is moved by less than a pixel to the right and upwards:
  /// the mean of such pictures has more samples than one.
  void set_shift(const Eigen::Vector2f& pixels);

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
