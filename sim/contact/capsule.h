// Where a capsule may touch a convex solid, and how deep anything is in an obstacle.
#pragma once

#include <array>
#include <cstdint>

#include "sim/motion/types.h"
#include "sim/world/shape.h"
#include "sim/world/world.h"

namespace taut::contact {

/// A point of a capsule's axis that may be the one which touches: an end; the nearest between them;
/// and the first and the last of those between the ends that are nearest but for a slight turn, of
/// a capsule which lies flat on a solid. Tipped about such an end, it touches beside that.
enum class Spot : std::uint8_t { from, to, nearest, first, last };
inline constexpr std::array<Spot, 5> kSpots{Spot::from, Spot::to, Spot::nearest, Spot::first,
                                            Spot::last};

/// A capsule in the world: all that is within `radius` (m) of the line between two points.
struct Capsule {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  double radius = 0;

  Vec3 at(double along) const { return from + along * (to - from); }
};

struct SpotGap {
  double along = 0;             // of the axis, 0 to 1
  double distance = 0;          // m, of the surfaces there; negative: inside
  Vec3 normal = Vec3::UnitY();  // out of the solid, world axes
  bool distinct = true;         // it is none of the others
  bool even = false;            // of the first and the last: distances rise evenly between them
};

/// The gap at a point of the axis.
SpotGap gap_at(const Shape& shape, const Pose& frame, const Capsule& capsule, double along);
/// The gap at a spot, which is wherever the capsule's place makes it.
SpotGap gap_at(const Shape& shape, const Pose& frame, const Capsule& capsule, Spot spot);

/// The gaps at all spots, in the order of kSpots. Spots which are an end, or where others on both
/// sides are as near, are not `distinct`.
std::array<SpotGap, 5> all_gaps(const Shape& shape, const Pose& frame, const Capsule& capsule);

/// Whether a spot that touches as a capsule goes from one place to another, and the solid from one
/// frame to another, moves farther along the axis than it rolls or slides: to the other end of what
/// lies flat.
bool tips(const Shape& shape, const Pose& start, const Capsule& from, double from_along,
          const Pose& end, const Capsule& to, double to_along);

/// The least of the distances of a capsule (m).
double least_gap(const Shape& shape, const Pose& frame, const Capsule& capsule);
/// The distance of two capsules (m).
double least_gap(const Capsule& solid, const Capsule& capsule);

/// How deep (m) the bead or the free body's capsule is that is deepest in an obstacle, or the link
/// that is deepest in another; zero where none is in one.
double penetration_max(const World& world);

}  // namespace taut::contact
