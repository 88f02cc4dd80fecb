// A keyframed path: positions and orientations through keys, C2 in time.
#pragma once

#include <optional>
#include <vector>

#include "sim/types.h"

namespace taut {

/// One key of a path. `ease` brings the path to rest at the key (velocity and acceleration zero);
/// two neighbouring keys that ease and share their pose are a hold.
struct PathKey {
  double time = 0;  // s
  Vec3 position = Vec3::Zero();
  Quat rotation = Quat::Identity();
  bool ease = false;
};

/// Position and orientation as functions of time, twice continuously differentiable, passing
/// through every key. Before the first key and after the last the path rests.
class Path {
 public:
  /// Keys need strictly rising times; throws std::invalid_argument otherwise or when empty.
  explicit Path(std::vector<PathKey> keys);

  /// The exact motion at `time` (s): its derivatives are those of the spline, not differences.
  FrameMotion at(double time) const;

  const std::vector<PathKey>& keys() const { return keys_; }

 private:
  std::vector<PathKey> keys_;
  // Values and their first two derivatives at the keys, 7 rows: x y z, then quaternion w x y z.
  using Row = Eigen::Matrix<double, 7, 1>;
  std::vector<Row> value_, rate_, rate2_;
};

}  // namespace taut
