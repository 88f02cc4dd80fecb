// Which states a motion needs that goes straight from one to the next.
#pragma once

#include <functional>
#include <vector>

#include "sim/run/trajectory.h"

namespace taut::exporting {

/// Takes states in the order of their times. Every frame is a key, and whatever else brings the
/// straight lines within the limit of the other states.
class LinearKeys {
 public:
  static constexpr double kLimit = 5e-5;  // m

  /// `radii` tell of each body how far from its origin there is something to see, m.
  explicit LinearKeys(std::vector<double> radii) : radii_(std::move(radii)) {}

  void add(Snapshot state, bool is_frame, const std::function<void(const Snapshot&)>& key);

  double error() const { return error_; }  // the largest distance, m

 private:
  double off(const Snapshot& from, const Snapshot& to, const Snapshot& state) const;
  void divide(std::size_t from, std::size_t to, const std::function<void(const Snapshot&)>& key);

  std::vector<double> radii_;
  std::vector<Snapshot> pending_;  // from the last frame on
  double error_ = 0;
};

}  // namespace taut::exporting
