// Newton's method on friction: how much of a change is taken.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace taut::direct {

constexpr int kIterations = 80;  // of Newton's method, at most

/// Shares of all friction, for problems that have to be approached.
constexpr std::array kShares{0.0, 0.3, 0.6, 0.8, 1.0};

/// How much of Newton's changes is taken: all as long as touches stay as they are. Those that
/// change their state to and fro, between sticking and sliding say, need less.
class Damping {
 public:
  /// The share of the next change, where the touches are in the states of this number.
  double next(std::uint64_t pattern) {
    if (iteration_++ >= kUndamped) {
      share_ = pattern == last_ ? std::min(1.0, 2 * share_) : std::max(0.1, 0.7 * share_);
    }
    last_ = pattern;
    return share_;
  }

 private:
  static constexpr int kUndamped = 6;

  int iteration_ = 0;
  double share_ = 1;
  std::uint64_t last_ = 0;
};

}  // namespace taut::direct
