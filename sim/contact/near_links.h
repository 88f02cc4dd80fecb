// Which links of connectors may touch each other, and where two capsules are nearest.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/motion/types.h"
#include "sim/world/world.h"

namespace taut::contact {

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
