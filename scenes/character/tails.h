// The hanging tails of a belt: where they swing to while the body moves.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "scenes/character/skeleton.h"
#include "scenes/character/track.h"

namespace taut::scenes {

/// Two tails of two bones each, hanging from the pelvis. At rest they lie where the cloth over
/// pelvis and thighs carries them; when that moves, their bend and their end follow as pendulums
/// do, the end on top of the bend.
class Tails {
 public:
  /// None where the model has no bones for them.
  explicit Tails(const Skeleton& skeleton);

  /// How far bends and ends are from where they lie (12 rows, m): left bend, left end, right bend,
  /// right end. `placed` tells the body at any time; it is at rest before the first sample.
  Track swing(double duration, double rate,
              const std::function<Placement(double time)>& placed) const;
  /// Turns the tails' bones so that bends and ends are there, as far as their lengths allow.
  void hang(const Eigen::VectorXd& offsets, Placement& placed) const;

 private:
  struct Tail {
    std::size_t upper, lower, own_thigh, other_thigh;
    Vec3 bend, end;  // at rest, m
  };
  /// Where cloth carries a point of a tail; `on_pelvis` is the pelvis' share of it.
  Vec3 carried(const Tail& tail, const Vec3& rest, double on_pelvis, const Placement& placed) const;
  std::vector<Vec3> lying(const Placement& placed) const;

  const Skeleton& skeleton_;
  std::size_t hips_ = 0;
  std::vector<Tail> tails_;
};

}  // namespace taut::scenes
