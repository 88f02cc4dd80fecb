// Pictures of a stage without any saving, for the others to be compared with: every triangle is
// drawn over the whole picture, in every exposure.
#pragma once

#include "render/draw/jitter.h"
#include "render/draw/motion_extents.h"
#include "render/draw/stage_parts.h"

namespace taut::draw {

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

}  // namespace taut::draw
