// Shadows of what moves on what is slower: many instants of them in one drawing of the latter.
#pragma once

#include <span>
#include <vector>

#include "render/draw/motion_extents.h"
#include "render/draw/stage_parts.h"

namespace taut::draw {

/// Slow things take fewer exposures than the shadows that sweep over them. So each of their
/// exposures looks up several maps, the layers: in each things stand where their own exposures show
/// them at one instant of the shutter.
class SweptShadows {
 public:
  /// `changing` is the part of the map in which something moves, `casters` that in which anything
  /// casts; the map's saved state has what stands. All must outlive this.
  SweptShadows(StageParts& parts, const MotionExtents& extents, std::span<const FrameState> shutter,
               std::span<const Exposures> grades, int samples, const FrameBlock& block,
               const picture::Rect& changing, const picture::Rect& casters);

  /// Draws the layers.
  void fill();
  /// Whether the exposures of that grade look up layers; others are often enough themselves.
  bool is_layered(int grade) const { return exposures_of(grade) < count_; }
  /// How exposure `i` of a grade looks them up: those of its share of the shutter.
  FrameBlock seen(int grade, int i) const;

 private:
  int exposures_of(int grade) const {
    return grade > 0 ? grades_[std::size_t(grade) - 1].count : 1;
  }

  StageParts& parts_;
  const MotionExtents& extents_;
  const std::span<const FrameState> shutter_;
  const std::span<const Exposures> grades_;
  FrameBlock block_;
  const picture::Rect changing_;
  int count_;  // of layers
};

}  // namespace taut::draw
