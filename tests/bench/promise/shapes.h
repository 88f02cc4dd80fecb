// Shapes that a connector starts in: the directions of its links.
#pragma once

#include <vector>

#include "sim/world/connector.h"

namespace taut::promise {

using Directions = std::vector<Vec3>;  // unit vectors, of one link each

/// The unit vector `tilt` (rad) from straight down, turned by `azimuth` (rad) about the vertical.
Vec3 from_down(double tilt, double azimuth);

Directions straight(std::size_t links, const Vec3& along);

/// Straight pieces, by turns `angle` (rad) to one side of `along` and to the other.
Directions zigzag(std::size_t links, std::size_t pieces, const Vec3& along, double angle);

/// Each link turned from the one before, `turn` (rad) in all, about an axis that turns about
/// `along` by `twist` (rad) in all.
Directions bent(std::size_t links, const Vec3& along, double turn, double twist);

/// A connector at rest whose links go that way from `start`.
Connector shaped(const char* name, double length, double mass, const Vec3& start,
                 const Directions& directions);

/// Moves the particles from `first` on as a rigid body that passes `about` at `velocity` (m/s) and
/// turns by `spin` (rad/s): no link's length changes.
void move(Connector& connector, std::size_t first, const Vec3& about, const Vec3& velocity,
          const Vec3& spin);

}  // namespace taut::promise
