// Bodies that touch each other, in whatever way, and what they touch.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/body_touch.h"

namespace taut::contact {

/// Divides bodies into clusters: the impulse of one touch may change all of its cluster, and
/// nothing else. A body that touches no other is a cluster of its own.
class Clusters {
 public:
  void find(std::size_t bodies, std::span<const BodyTouch> touches);

  /// The body that a cluster is numbered by: the first of it.
  std::uint32_t of(std::uint32_t body) const { return root_[body]; }
  std::uint32_t of(const BodyTouch& at) const { return root_[at.body]; }

  /// Calls it with the first touch of each cluster and how many it has, of touches in order of
  /// their clusters.
  template <typename Visit>
  void each(std::span<const BodyTouch> touches, const Visit& visit) const {
    for (std::size_t first = 0, end = 0; first < touches.size(); first = end) {
      while (end < touches.size() && of(touches[end]) == of(touches[first])) ++end;
      visit(first, end - first);
    }
  }

 private:
  std::uint32_t first_of(std::uint32_t body);

  std::vector<std::uint32_t> root_;
};

}  // namespace taut::contact
