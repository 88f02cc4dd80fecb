// The palm's skin, and how near a stick lies to it.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "scenes/character/capsules.h"
#include "scenes/character/skeleton.h"

namespace taut::scenes {

/// Turns of bones against their parents, by bone.
using FingerTurns = std::vector<std::pair<std::size_t, Quat>>;

/// The skin that moves most with a hand's own bone.
class Palm {
 public:
  Palm(const Model& model, const Skeleton& skeleton, std::size_t hand);

  /// Where it is when the fingers are turned so.
  std::vector<Vec3> bent(const FingerTurns& fingers) const;

 private:
  const Skeleton& skeleton_;
  std::vector<Vertex> skin_;
};

/// The least distance of points from a stick's surface, within a finger's breadth of each of the
/// places along it.
std::vector<double> gaps_along(const std::vector<Vec3>& points, const Capsule& stick,
                               std::span<const double> places);

}  // namespace taut::scenes
