// Moving points and frames as cubic splines over one list of keys.
#pragma once

#include <functional>
#include <vector>

#include "sim/motion/types.h"

namespace taut::exporting {

/// Takes states in the order of their times and keeps as few of them as keys as bring the splines
/// near the others: every frame is one, and whatever the limit needs between.
class SplineTracks {
 public:
  struct State {
    double time = 0;  // s
    std::vector<Vec3> points;
    std::vector<Pose> frames;
  };
  static constexpr double kLimit = 5e-5;  // m, by which splines may be off the states given

  /// `radii` tell of each frame how far from its origin there is something to see, m.
  SplineTracks(std::size_t points, std::vector<double> radii);

  /// Calls `key` with the index of each state that becomes one, counted from the first ever added.
  void add(State state, bool is_frame, const std::function<void(std::size_t)>& key);

  const std::vector<float>& times() const { return times_; }
  /// For every key: the slope before it, its value and the slope behind it, as glTF wants them.
  const std::vector<float>& point(std::size_t i) const { return points_[i]; }
  const std::vector<float>& position(std::size_t frame) const { return positions_[frame]; }
  /// Quaternions x, y, z, w.
  const std::vector<float>& rotation(std::size_t frame) const { return rotations_[frame]; }

  /// The largest distance of a point from its states, and of what is to see of a frame, m.
  double point_error() const { return point_error_; }
  double frame_error() const { return frame_error_; }

 private:
  using Vec4 = Eigen::Vector4d;
  struct Span;
  Span fit(std::size_t from, std::size_t to) const;
  void divide(std::size_t from, std::size_t to, const std::function<void(std::size_t)>& key);
  void first_key();

  std::vector<double> radii_;
  std::vector<State> pending_;  // from the last frame on
  std::size_t before_ = 0;      // states before these
  std::vector<float> times_;
  std::vector<std::vector<float>> points_, positions_, rotations_;
  double point_error_ = 0, frame_error_ = 0;
};

}  // namespace taut::exporting
