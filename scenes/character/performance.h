// The poses of a character's bones over time, worked out before the simulation runs.
#pragma once

#include <vector>

#include "sim/motion/types.h"

namespace taut::scenes {

class Performance {
 public:
  virtual ~Performance() = default;
  /// World-space pose of every bone (order of Model::bones) at `time` (s); a pure function of time.
  virtual std::vector<Pose> bones_at(double time) const = 0;
  /// The pose of a bone that is not of cloth, at less cost. Throws std::out_of_range.
  virtual Pose limb_at(std::size_t bone, double time) const { return bones_at(time).at(bone); }
};

}  // namespace taut::scenes
