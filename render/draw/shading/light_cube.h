// The light around a point, as six square pictures show it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/draw/shading/lighting.h"

namespace taut::draw {

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

}  // namespace taut::draw
