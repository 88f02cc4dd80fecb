// A camera turned and zoomed so that things fill its picture.
#pragma once

#include <span>

#include "scenes/scene/stage.h"

namespace taut::film {

/// The camera where it stands, turned and zoomed until all points (m) lie in the picture below
/// `top`, a share of its height, with a little room around them. Points behind it do not count.
/// `aspect` is width / height of the picture.
scenes::CameraView framed(const scenes::CameraView& camera, std::span<const Vec3> points,
                          double aspect, double top);

/// Pixels to a metre as far away as the camera's target, in a picture so high.
double pixels_per_metre(const scenes::CameraView& camera, int height);

/// A length (m) of 1, 2 or 5 times a power of ten, the longest that is not above `most`.
double round_length(double most);

}  // namespace taut::film
