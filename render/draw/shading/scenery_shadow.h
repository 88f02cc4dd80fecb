// The key light where the scenery shuts it out or lets it in.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>

#include "render/draw/shading/drawable.h"
#include "render/gl/gpu.h"
#include "scenes/scene/stage.h"

namespace taut::draw {

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
