// Distances: a capsule and a convex solid, two capsules; depths in obstacles; candidate pairs of
// links.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/motion/types.h"
#include "sim/world/obstacle.h"
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

/// The least of the distances of a capsule (m).
double least_gap(const Shape& shape, const Pose& frame, const Capsule& capsule);
/// The distance of two capsules (m).
double least_gap(const Capsule& solid, const Capsule& capsule);

/// How deep (m) the bead or the free body's capsule is that is deepest in an obstacle, or the link
/// that is deepest in another; zero where none is in one.
double penetration_max(const World& world);

// Which links of connectors may touch each other, and where two capsules are nearest.

/// The nearest points of two segments, as shares of the way along each.
struct NearestShares {
  double first = 0, other = 0;  // 0 to 1
};
/// Segments may have no length. Of parallel ones any of the nearest pairs.
NearestShares nearest_shares(const Vec3& from, const Vec3& to, const Vec3& other_from,
                             const Vec3& other_to);

/// The distance (m) of two segments.
double distance(const Vec3& from, const Vec3& to, const Vec3& other_from, const Vec3& other_to);

/// Two links that may touch. Points are all particles, connector by connector.
struct LinkPair {
  std::uint32_t a = 0, b = 0;  // the first point of each link; a < b
  std::uint32_t rule = 0;      // of World::connector_pairs
};

/// The links of connectors that touch each other or themselves (World::connector_pairs).
///
/// A rope bent as sharply as its radius r allows turns back in half a circle: points of its axis
/// that are pi r apart along the rope are 2 r apart in space, and nearer ones have no room to
/// touch. So two links do not touch where the rope between them is shorter than pi r, or where they
/// meet. The rope may lead through joints, and through ends that are at one place at the start or
/// after a cut.
class NearLinks {
 public:
  void rebuild(const World& world);
  bool any() const { return !links_.empty(); }

  /// All pairs of links whose surfaces are nearer than `within` (m), sorted. `position`: three
  /// numbers (m) for each point.
  void find(std::span<const double> position, double within, std::vector<LinkPair>& pairs);
  /// Whether there is such a pair.
  bool is_any(std::span<const double> position, double within);

 private:
  struct Link {
    std::uint32_t point = 0, connector = 0;
    double radius = 0;  // m
  };
  struct Box {
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
    std::uint32_t link = 0;
  };
  struct Rule {
    std::uint32_t other = 0, rule = 0;
  };
  struct Near {
    std::uint32_t point = 0;
    double along = 0;  // m of rope to there
  };

  void find_near_along(const World& world);
  bool are_near_along(std::uint32_t a, std::uint32_t b, double least) const;
  template <typename Visit>
  void each_pair(std::span<const double> position, double within, Visit visit);

  std::vector<Link> links_;
  std::vector<std::vector<Rule>> rules_;       // of each connector
  std::vector<std::vector<Near>> near_along_;  // of each point, by points: itself and others
  std::vector<Box> boxes_;
  std::vector<std::uint32_t> open_;  // boxes that the sweep has not left behind
};

/// How deep (m) the link is that is deepest in another which it touches (World::connector_pairs);
/// zero where none is in one.
double deepest_link(const World& world);

}  // namespace taut::contact
