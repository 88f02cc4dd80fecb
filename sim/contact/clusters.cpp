#include "sim/contact/clusters.h"

#include <algorithm>
#include <numeric>

namespace taut::contact {

std::uint32_t Clusters::first_of(std::uint32_t body) {
  while (root_[body] != body) body = root_[body] = root_[root_[body]];
  return body;
}

void Clusters::find(std::size_t bodies, std::span<const BodyTouch> touches) {
  root_.resize(bodies);
  std::iota(root_.begin(), root_.end(), 0);
  for (const BodyTouch& at : touches) {
    if (at.other == kNoBody) continue;
    const std::uint32_t a = first_of(at.body), b = first_of(at.other);
    root_[std::max(a, b)] = std::min(a, b);
  }
  for (std::uint32_t b = 0; b < root_.size(); ++b) root_[b] = first_of(b);
}

}  // namespace taut::contact
