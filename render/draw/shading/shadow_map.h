// The shadow map: depth of the nearest caster along the key light.
#pragma once

#include <span>
#include <vector>

#include "render/draw/shading/draw_item.h"
#include "render/gl/gpu.h"
#include "render/picture/rect.h"

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

}  // namespace taut::draw
