// Which pixels things and their shadows can touch.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "render/picture/rect.h"

namespace taut::draw {

/// Points in space, whose hull is everything that is meant.
using HullPoints = std::vector<Eigen::Vector3f>;

void add_box(const Eigen::AlignedBox3f& box, HullPoints& hull);

/// The shadow that a box throws along `direction` on whatever lies inside `receivers`.
void add_shadow(const Eigen::AlignedBox3f& box, const Eigen::Vector3f& direction,
                const Eigen::AlignedBox3f& receivers, HullPoints& hull);

/// The pixels of `viewport` that the hull can touch; all of them where it comes behind the eye.
picture::Rect pixels(const HullPoints& hull, const Eigen::Matrix4f& projection,
                     const picture::Rect& viewport);

}  // namespace taut::draw
