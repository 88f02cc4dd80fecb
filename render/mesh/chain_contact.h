// A chain lies on what it hangs on.
#pragma once

#include <span>
#include <vector>

#include "sim/motion/types.h"

namespace taut::mesh {

/// The end of a round bar that a chain hangs on, for the middles of its links: they stay out of it.
struct BarEnd {
  Vec3 top;         // where the chain is attached, m
  Vec3 axis;        // out of the bar, unit
  double radius;    // m
  double rounding;  // m, of the rim
};

/// How far a point is outside; negative inside.
double distance(const BarEnd& bar, const Vec3& point);

/// The points of a chain, those inside bars moved out, their neighbours along with them, so that
/// links keep their lengths where the chain has slack enough. The first and the last point stay,
/// and so do all where none is inside. Simulations know no such contact: pictures lay a cord around
/// a ferrule that it passes through.
std::vector<Vec3> clear_of(std::span<const BarEnd> bars, std::span<const Vec3> points);

}  // namespace taut::mesh
