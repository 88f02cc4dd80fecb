// The light that a stage's scenery throws back, gathered from pictures of it.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>
#include <vector>

#include "render/draw/shading/drawable.h"
#include "render/draw/shading/lighting.h"
#include "render/draw/shading/surfaces.h"

namespace taut::draw {

/// Indirect light in a room. The scenery is drawn as cubes of pictures around points of a grid, in
/// the key light, with what glows and with the stage's ambient light for all further bounces. What
/// the pictures show becomes irradiance in spherical harmonics (Ramamoorthi and Hanrahan 2001),
/// linear between the points; one cube more, blurred by roughness (Karis 2013), is what glossy
/// surfaces mirror.
class RoomLight {
 public:
  /// `things` are drawn in world space. `middle` (m): where what moves is lit, or
  /// as near to it as the room reaches. Scenery that
  /// encloses no room (a side under 1 m) throws nothing back.
  RoomLight(const gl::Gl& gl, const scenes::Light& light, std::span<Drawable> things,
            const Vec3& middle);

  bool encloses() const { return !grid_.empty(); }
  /// Irradiance over pi (linear rgb) on each of the vertices of a thing of the scenery.
  std::vector<Eigen::Vector3f> on(const scenes::Mesh& mesh) const;
  /// The shaders' view of the room's light.
  Surroundings surroundings() const;

 private:
  Harmonics at(const Vec3& point) const;

  Eigen::AlignedBox3d room_;
  Eigen::AlignedBox3d points_;   // the grid's corners
  std::vector<Harmonics> grid_;  // [z][y][x]
  Harmonics middle_light_{};
  Vec3 middle_ = Vec3::Zero();
  gl::GlObject mirror_;
};

}  // namespace taut::draw
