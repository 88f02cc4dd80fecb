// Light as the shaders take it: ambient light in spherical harmonics, and the key light's map.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>

#include "render/gl/defocus.h"
#include "scenes/scene/stage.h"

namespace taut::draw {

/// Nine coefficients of irradiance/pi (rgb, linear), such that with a unit normal (x, y, z) it is
/// c0 + c1 y + c2 z + c3 x + c4 xy + c5 yz + c6 (3z^2 - 1) + c7 xz + c8 (x^2 - y^2).
using Harmonics = std::array<Eigen::Vector3f, 9>;

/// The light past all scenery: sky above, ground below that reflects the key light like a floor.
Vec3 surrounding_light(const scenes::Light& light, const Vec3& direction);

/// What shines on paper from behind: as bright as the key light, of the sky's colour.
Vec3 daylight(const scenes::Light& light);

/// Radiance seen from a point, added up by direction.
class HarmonicSum {
 public:
  /// `direction` is a unit vector, `solid_angle` in sr.
  void add(const Vec3& direction, const Vec3& radiance, double solid_angle);
  /// The irradiance on a surface.
  Harmonics irradiance() const;

 private:
  std::array<Vec3, 9> sum_{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(),
                           Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
};

/// The ambient light of a stage: sky above, ground below, and what the ground throws back of the
/// key light (Ramamoorthi and Hanrahan 2001).
Harmonics ambient_harmonics(const scenes::Light& light);

/// The stage's light as constants of a shader: TO_LIGHT (unit), LIGHT_COLOR, DAYLIGHT, SKY, GROUND
/// and `ambient` as AMBIENT. Constants, because software rasterisers load uniforms anew for every
/// pixel.
std::string light_constants(const scenes::Light& light, const Harmonics& ambient);

/// World to the unit cube of the shadow map: x and y across the light, z along it. It covers the
/// box; its size and place move in steps, so that shadow edges do not crawl from frame to frame.
struct LightMap {
  Eigen::Matrix4f projection;
  double texel = 0;  // m
};
LightMap light_map(const Vec3& direction, const Eigen::AlignedBox3d& casters, int resolution);

constexpr float kSun = 0.0047f;  // rad, the radius of its disc

/// Half of a shadow's penumbra in widths of its map, for each of the map's depths between what
/// throws it and what it falls on.
float penumbra(const Eigen::Matrix4f& light_projection);

/// World to clip space. The picture's aspect is width / height.
Eigen::Matrix4f camera_projection(const scenes::CameraView& camera, double aspect);

/// How a thin lens blurs a picture of that height (px): its focal length is that of a pinhole with
/// the same field of view 24 mm behind the picture's height, its plane of focus stays where it is.
gl::Confusion confusion(const scenes::CameraView& camera, int height);

}  // namespace taut::draw
