#include "scenes/scene/view.h"

#include <cmath>

namespace taut::scenes {

std::optional<Eigen::Vector2d> on_picture(const CameraView& camera, double aspect,
                                          const Vec3& point) {
  const Vec3 ahead = (camera.target - camera.position).normalized();
  const Vec3 up = std::abs(ahead.y()) > 0.999 ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
  const Vec3 right = ahead.cross(up).normalized(), to = point - camera.position;
  const double far = to.dot(ahead), half = std::tan(camera.field_of_view / 2);
  if (!(far > 0)) return std::nullopt;
  return Eigen::Vector2d(to.dot(right) / (far * half * aspect),
                         to.dot(right.cross(ahead)) / (far * half));
}

}  // namespace taut::scenes
