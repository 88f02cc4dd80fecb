// The parts that a stage's pictures are made with.
#pragma once

#include <optional>
#include <vector>

#include "render/draw/moving_parts.h"
#include "render/draw/shading/contact.h"
#include "render/draw/shading/room_light.h"
#include "render/draw/shading/scenery_shadow.h"
#include "render/draw/shading/shadow_map.h"
#include "render/draw/shading/surfaces.h"
#include "render/draw/view.h"
#include "render/gl/canvas.h"

namespace taut::draw {

using Boxes = std::vector<Eigen::AlignedBox3f>;

/// How a picture of an instant is seen and lit, and what feet can darken.
struct Look {
  FrameBlock block;
  Boxes contacts;
};

/// A stage's meshes, surfaces and shadow map on the graphics side.
struct StageParts {
  StageParts(const gl::Context& context, const scenes::Stage& stage, const World& world,
             const Shading& shading);

  Look look(const FrameState& instant, const picture::Rect& viewport) const;
  /// Opaque triangles with depth are drawn from now on, over the whole target.
  void draw_solid() const;
  /// The canvas' viewport is drawn to; the shadow map and blurred light can be looked up.
  void aim(const gl::Canvas& canvas, const picture::Rect& viewport) const;
  /// The background everywhere.
  void clear(const gl::Canvas& canvas) const;
  void draw_scenery(Shade shade);

  const gl::Gl& gl;
  const scenes::Stage& stage;
  const Shading shading;
  Vec3 background;
  std::vector<Drawable> scenery;
  SceneryShadow scenery_shadow;
  RoomLight room;
  const CapsuleCounts capsules;
  Surfaces surfaces;
  ShadowMap map;
  MovingParts parts;

 private:
  std::vector<std::optional<ContactCapsule>> rods_;  // [body]
  std::vector<std::vector<scenes::Capsule>> arms_;   // [character]
};

/// The background and the scenery of all views in light that nothing takes, blurred by the lenses.
void draw_backdrop(StageParts& parts, gl::Canvas& canvas, std::span<const View> views);

/// How exposure `i` of several is seen and lit: picture and light are moved.
FrameBlock exposed(const FrameBlock& block, const FrameState& middle, const picture::Rect& viewport,
                   int i);
/// The state of exposure `i` of so many: states evenly apart.
const FrameState& shown_at(std::span<const FrameState> shutter, int i, int count);
/// How shadows are looked up in one of so many exposures.
Shade shade_of(int count, int samples);

}  // namespace taut::draw
