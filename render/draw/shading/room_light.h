// The light that a stage's scenery throws back, gathered from pictures of it around a point.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "render/draw/shading/drawable.h"
#include "render/draw/shading/lighting.h"
#include "render/draw/shading/shadow_map.h"
#include "render/draw/shading/surfaces.h"

namespace taut::draw {

// The light around a point, as six square pictures show it.

/// Across, up and ahead of a cube's six sides, in OpenGL's order.
std::array<Mat3, 6> cube_sides();

/// A pixel of a cube: where it is, its share of the sphere, and its light.
struct CubePixel {
  Vec3 direction;      // unit
  double solid_angle;  // sr
  Vec3 radiance;
};

/// The pixel (i, j) of a side that is `size` wide, without light.
CubePixel cube_pixel(const Mat3& side, int i, int j, int size);

/// The irradiance of a cube's light.
Harmonics harmonics(std::span<const CubePixel> cube);

/// Irradiance over pi (linear rgb) on faces towards +x, -x, +y, -y, +z and -z.
using SideLight = std::array<Eigen::Vector3f, 6>;
SideLight side_light(std::span<const CubePixel> cube);

/// A cube of light, and what it is when it is half as wide, and so on.
class CubeMips {
 public:
  /// Sides of `size` px, a power of two, side by side, rows from below.
  CubeMips(std::span<const CubePixel> cube, int size);

  /// The mirrored light of a surface of that roughness in a direction: the mean by the lobe of GGX,
  /// seen along its axis, of samples with their solid angles (Krivanek and Colbert 2008).
  Vec3 blurred(const Vec3& ahead, double roughness) const;

 private:
  /// The light from a direction, mean over that solid angle (sr).
  Vec3 from(const Vec3& direction, double solid_angle) const;

  int size_;
  std::array<Mat3, 6> sides_ = cube_sides();
  std::vector<std::vector<Vec3>> levels_;
};

/// Indirect light in a room. The scenery is drawn as cubes of pictures around points of a grid, in
/// the key light and with what glows; then once more in the light that this throws back, so that
/// two bounces are seen. What the pictures show becomes the irradiance of six sides (McTaggart
/// 2004): walls at right angles take it without loss. It is linear between the points. One cube
/// more lights what moves, by spherical harmonics (Ramamoorthi and Hanrahan 2001), and is, blurred
/// by roughness (Karis 2013), what glossy surfaces mirror.
class RoomLight {
 public:
  /// `things`, those of the `meshes` in world space, are bathed in it. `middle` (m): where what
  /// moves is lit, or as near to it as the room reaches. Scenery that encloses no room (a side
  /// under 1 m) throws nothing back.
  RoomLight(const gl::Gl& gl, const scenes::Light& light, std::span<Drawable> things,
            std::span<const scenes::Mesh* const> meshes, const SceneryShadow& shadow,
            const Vec3& middle);

  bool encloses() const { return !grid_.empty(); }
  /// Irradiance over pi (linear rgb) on each of the vertices of a thing of the scenery.
  std::vector<Eigen::Vector3f> on(const scenes::Mesh& mesh) const;
  /// The shaders' view of the room's light.
  Surroundings surroundings() const;

 private:
  SideLight at(const Vec3& point) const;

  Eigen::AlignedBox3d room_;
  Eigen::AlignedBox3d points_;   // the grid's corners
  std::array<int, 3> count_{};   // its points by x, y, z
  std::vector<SideLight> grid_;  // [z][y][x]
  Harmonics middle_light_{};
  Vec3 middle_ = Vec3::Zero();
  gl::GlObject mirror_;
};

}  // namespace taut::draw
