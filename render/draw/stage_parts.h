// The parts that a stage's pictures are made with, those that move among them.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/draw/shading/drawable.h"
#include "render/draw/shading/room_light.h"
#include "render/draw/shading/shadow_map.h"
#include "render/draw/shading/surfaces.h"
#include "render/draw/view.h"
#include "render/gl/canvas.h"
#include "render/mesh/connector_mesh.h"
#include "scenes/scene/stage.h"
#include "sim/world/world.h"

namespace taut::draw {

// The moving parts of a stage: characters, bodies and connectors, on the graphics side.

class MovingParts {
 public:
  /// `world` tells what connectors hang on; its state does not matter. The stage must outlive this.
  MovingParts(const gl::Gl& gl, const scenes::Stage& stage, const World& world);

  /// Moves everything to where it is at that time. The instant must live until all is drawn.
  void pose(const FrameState& instant);
  /// How many triangles there are.
  std::size_t triangles() const;
  /// The layer's items at the instant last posed: the same for each instant, in the same order.
  std::vector<DrawItem> items(const FrameState& instant, const Layer& layer = {});
  /// Where the vertices of one of all items are at that time, in world space; moves nothing.
  void find_places(const FrameState& instant, std::size_t item, Places& places);

 private:
  const scenes::Stage& stage_;
  std::vector<std::vector<Drawable>> bodies_, characters_;  // [body or character][mesh]
  std::vector<std::unique_ptr<mesh::ConnectorMesh>> connector_meshes_;
  std::vector<Drawable> connectors_;
  struct Winched {
    std::size_t connector = 0;
    std::shared_ptr<const Winch> winch;
    double length = 0, longer = 0;  // m: with which it was made, and what had been paid out then
    std::optional<std::size_t> enters = {}, leaves = {};  // pulleys, by which rope does
    /// At the first end, and in all (m).
    std::array<double, 2> paid_out(double time, std::span<const double> passed) const;
  };
  std::vector<Winched> winched_;
  std::vector<mesh::MovingVertex> vertices_;
};

/// Where the vertices of an item are, in world space, as it was last moved.
Places places_of(const DrawItem& item);

std::vector<Drawable> drawables(const gl::Gl& gl, const scenes::Model& model);

/// A box around everything that moves, from bones, particles and bodies, in m.
Eigen::AlignedBox3d extent(const FrameState& instant);

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
  Eigen::Vector2f shift{0, 0};  // px, of all that is drawn
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
