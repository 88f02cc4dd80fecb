// A camera's view of a point.
#pragma once

#include <optional>

#include "scenes/scene/stage.h"

namespace taut::scenes {

/// Where a camera sees a point: -1 to 1 from left to right and from the lower to the upper edge of
/// a picture of that aspect, width over height; none behind the camera.
std::optional<Eigen::Vector2d> on_picture(const CameraView& camera, double aspect,
                                          const Vec3& point);

}  // namespace taut::scenes
