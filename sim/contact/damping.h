// Newton's method on friction: how much of a change is taken.
#pragma once

#include <algorithm>
#include <cstdint>

namespace taut::contact {

inline constexpr int kIterations = 80;  // of Newton's method, at most

/// The share of Newton's changes that is taken: all as long as touches stay as they are. Touches
/// that change their state to and fro, between sticking and sliding say, need less. Where a change
/// of states travels along a connector, a relaxation takes it there.
class Damping {
 public:
  /// Call once in an iteration, with a number of the states that the touches are in. Whether to
  /// relax the rows one by one, rather than to take a share() of Newton's change.
  bool relaxes(std::uint64_t pattern) {
    const bool changed = pattern != last_;
    last_ = pattern;
    if (++iteration_ <= kUndamped) return changed && iteration_ % kRelaxed == 0;
    share_ = changed ? std::max(0.1, 0.7 * share_) : std::min(1.0, 2 * share_);
    return changed && iteration_ % kRelaxed == 0;
  }
  double share() const { return share_; }

 private:
  static constexpr int kUndamped = 6, kRelaxed = 4;

  int iteration_ = 0;
  double share_ = 1;
  std::uint64_t last_ = 0;
};

}  // namespace taut::contact
