// The moving parts of a stage: characters, bodies and connectors, on the graphics side.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/draw/frame_state.h"
#include "render/draw/shading/draw_item.h"
#include "render/draw/shading/shadow_cover.h"
#include "render/mesh/connector_mesh.h"
#include "scenes/scene/stage.h"
#include "sim/world/world.h"

namespace taut::draw {

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

}  // namespace taut::draw
