#include "render/film/framing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace taut::film {
namespace {

constexpr double kRoom = 0.08;  // of the picture, on each side

}  // namespace

scenes::CameraView framed(const scenes::CameraView& camera, std::span<const Vec3> points,
                          double aspect, double top) {
  scenes::CameraView view = camera;
  const double distance = (camera.target - camera.position).norm();
  // Turning changes what is seen where: a few rounds settle it.
  for (int round = 0; round < 8; ++round) {
    const Vec3 forward = (view.target - view.position).normalized();
    const Vec3 right = forward.cross(Vec3::UnitY()).normalized(), up = right.cross(forward);
    Eigen::AlignedBox2d seen;  // tangents of the angles
    for (const Vec3& p : points) {
      const Vec3 from = p - view.position;
      const double depth = from.dot(forward);
      if (depth > 0.01 * distance)
        seen.extend(Eigen::Vector2d(from.dot(right), from.dot(up)) / depth);
    }
    if (seen.isEmpty()) return camera;
    const double high = seen.sizes().y() / (1 - top - 2 * kRoom);
    const double wide = seen.sizes().x() / (1 - 2 * kRoom) / aspect;
    const double height = std::max({high, wide, 1e-3});
    view.field_of_view = 2 * std::atan(height / 2);
    const Eigen::Vector2d centre = seen.center() + Eigen::Vector2d(0, height * top / 2);
    view.target =
        view.position + distance * (forward + centre.x() * right + centre.y() * up).normalized();
  }
  return view;
}

double pixels_per_metre(const scenes::CameraView& camera, int height) {
  return height /
         (2 * (camera.target - camera.position).norm() * std::tan(camera.field_of_view / 2));
}

double round_length(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double times : {5.0, 2.0})
    if (times * power <= most) return times * power;
  return power;
}

}  // namespace taut::film
