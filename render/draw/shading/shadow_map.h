// Shadows of the key light: its depth map, the shadows of scenery, and the triangles that
// shadows of moving things reach.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "render/draw/shading/drawable.h"
#include "render/gl/gpu.h"
#include "render/picture/picture.h"
#include "scenes/scene/stage.h"

namespace taut::draw {

/// The map's projection is the frame's in use (Surfaces::use).
class ShadowMap {
 public:
  ShadowMap(const gl::Gl& gl, int size);

  int size() const { return size_; }
  /// Surfaces can look it up: compared, and its depths.
  void bind() const;

  void clear() const;
  /// Adds casters. A lit rim stays, which stands for everything beyond the map.
  void draw(std::span<const DrawItem> casters) const;

  /// Makes room for a part of the map at so many instants.
  void start_layers(const picture::Rect& part, int count);
  /// Makes the part of the map as it is one of its layers.
  void keep_layer(int layer) const;
  /// Adds casters to a layer.
  void draw_layer(int layer, std::span<const DrawItem> casters) const;
  /// A place on the map to one on the layers: xy times, zw more.
  Eigen::Vector4f on_layers() const;

  /// Keeps a part of the map as it is, and brings it back.
  void save(const picture::Rect& part);
  void restore(const picture::Rect& part) const;

 private:
  void draw(const gl::GlObject& target, int x, int y, std::span<const DrawItem> casters) const;
  void copy(GLuint from, GLuint to, const picture::Rect& part) const;

  const gl::Gl& gl_;
  int size_;
  gl::GlObject map_, target_, saved_, depths_, layers_;
  picture::Rect layered_;
  std::vector<gl::GlObject> layer_targets_;
  gl::Program depth_program_;
};

// Which triangles of the scenery the shadows of moving things can reach.

/// Where the vertices of a mesh are, m, in world space.
using Places = std::vector<Eigen::Vector3f>;

/// The cover of the casters along the key light: a coarse grid over the shadow map with the depth
/// of the nearest caster in each cell.
class ShadowCover {
 public:
  /// `light_projection` takes the world to the unit cube of the shadow map; `filter` is how far
  /// beside a caster its shadow can still be felt, in widths of the map, and `penumbra` how much
  /// farther for each depth of the map away from it.
  void start(const Eigen::Matrix4f& light_projection, float filter, float penumbra);
  /// Adds casters: triangles as indices of vertices, which are at these places at one time or at
  /// several, and anywhere between.
  void add(std::span<const std::uint32_t> triangles, std::span<const Places> times);

  /// The triangles that the shadow can reach or that meet one of the boxes, in their order, as
  /// indices of vertices. Returns the box around them.
  Eigen::AlignedBox3f find(std::span<const std::uint32_t> triangles, const Places& places,
                           std::span<const Eigen::AlignedBox3f> boxes,
                           std::vector<std::uint32_t>& indices);

 private:
  static constexpr int kCells = 96;  // a side: about 2 cm on a person
  void project(const Places& places, Places& projected) const;
  bool hides(const Places& projected, const std::uint32_t* corner) const;

  Eigen::Matrix4f projection_;
  float filter_ = 0, penumbra_ = 0;
  Eigen::AlignedBox3f covered_;  // around all casters
  std::vector<float> nearest_;
  std::vector<Places> projected_;
};

// The key light where the scenery shuts it out or lets it in.

/// Depths of the scenery along the key light, drawn once, as scenery stands. Only faces that turn
/// away from the light are in it: so those that it falls on never shade themselves. Beside it are
/// the least and the greatest depth around each place: few surfaces need to look farther.
class SceneryShadow {
 public:
  /// `things` are in world space. Nothing is drawn unless the light asks for it.
  SceneryShadow(const gl::Gl& gl, const scenes::Light& light, std::span<Drawable> things);

  /// The text that goes before the shaders of surfaces.
  std::string constants() const;
  /// Surfaces can look it up.
  void bind() const;

 private:
  /// The texture of least and greatest depths.
  gl::GlObject spans() const;

  const gl::Gl& gl_;
  Eigen::Matrix4f projection_;  // world to the map's unit cube
  gl::GlObject depths_, spans_, plainly_;
};

}  // namespace taut::draw
