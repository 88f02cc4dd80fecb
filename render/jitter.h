// Where the exposures of one frame differ, so that together they smooth what each shows hard:
// edges by moving the picture within a pixel, shadows by moving the light within the sun's disc.
#pragma once

#include <Eigen/Core>

#include "render/rect.h"
#include "sim/types.h"

namespace taut {

/// How many exposures a frame takes to show `wanted` times or more, of as many states as there are:
/// `samples` times a power of two, as each takes one sample of every pixel; 1 where there are too
/// few states for that.
int exposures(double wanted, int samples, int states);

/// The projection of a picture in exposure `i`, moved by up to an eighth of a pixel: as much as
/// brings samples that the exposures share apart.
Eigen::Matrix4f moved_picture(const Eigen::Matrix4f& view_projection, const Rect& viewport, int i);

/// The projection by which surfaces look shadows up in exposure `i`, if the light comes from
/// another point of its disc. Casters count as being as far along the light as `casters`: so one
/// map does for all, and shadows grow softer with their distance from there.
Eigen::Matrix4f moved_light(const Eigen::Matrix4f& light_projection, const Vec3& casters, int i);

}  // namespace taut
