// Where the links of a chain are, and how they are turned about their own length.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/motion/types.h"

namespace taut::mesh {

/// The hold of a chain's end: a direction away from it, and one across, both unit vectors.
struct ChainHold {
  Vec3 axis, side;
};

/// A link between two joints. Neighbouring links are turned against one another by 90 degrees.
struct LinkFrame {
  Vec3 from, to;  // m
  Vec3 axis;      // from the one to the other, unit
  Vec3 wide;      // across the flat side, unit

  Vec3 middle() const { return (from + to) / 2; }
};

/// `links` links along the particles, each of the same share of the connector's length. They are
/// functions of these positions alone. Parallel transport from link to link would turn a link fast
/// and far about itself where its neighbour is folded back nearly onto it, and the fold moves: it
/// follows a smoothed direction instead, which folds widely, and each link is turned out of that by
/// the shortest way. The holds of the ends count as links.
std::vector<LinkFrame> link_frames(std::span<const Vec3> particles, std::size_t links,
                                   const std::optional<ChainHold>& first,
                                   const std::optional<ChainHold>& last);

/// The rotation that turns unit vector `from` onto unit vector `to` by the shortest way, applied to
/// `v`: parallel transport along a bend. Across `to` where `v` was across `from`, to rounding.
Vec3 transport(const Vec3& v, const Vec3& from, const Vec3& to);

}  // namespace taut::mesh
