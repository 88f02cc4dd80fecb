#include "render/export/linear_keys.h"

#include <algorithm>

namespace taut::exporting {

void LinearKeys::add(Snapshot state, bool is_frame,
                     const std::function<void(const Snapshot&)>& key) {
  pending_.push_back(std::move(state));
  if (!is_frame) return;
  if (pending_.size() == 1) return key(pending_.front());
  divide(0, pending_.size() - 1, key);
  pending_.erase(pending_.begin(), pending_.end() - 1);
}

double LinearKeys::off(const Snapshot& from, const Snapshot& to, const Snapshot& state) const {
  const double u = (state.time - from.time) / (to.time - from.time);
  double most = 0;
  const auto point = [&](const Vec3& a, const Vec3& b, const Vec3& at) {
    most = std::max(most, ((1 - u) * a + u * b - at).norm());
  };
  for (std::size_t c = 0; c < state.connectors.size(); ++c)
    for (std::size_t i = 0; i < state.connectors[c].size(); ++i)
      point(from.connectors[c][i], to.connectors[c][i], state.connectors[c][i]);
  for (std::size_t b = 0; b < state.bodies.size(); ++b) {
    point(from.bodies[b].position, to.bodies[b].position, state.bodies[b].position);
    const Quat turn = from.bodies[b].rotation.slerp(u, to.bodies[b].rotation);
    most = std::max(most, turn.angularDistance(state.bodies[b].rotation) * radii_[b]);
  }
  return most;
}

void LinearKeys::divide(std::size_t from, std::size_t to,
                        const std::function<void(const Snapshot&)>& key) {
  double largest = 0;
  std::size_t worst = from;
  for (std::size_t i = from + 1; i < to; ++i)
    if (const double distance = off(pending_[from], pending_[to], pending_[i]);
        distance > largest) {
      largest = distance;
      worst = i;
    }
  if (largest > kLimit) {
    divide(from, worst, key);
    return divide(worst, to, key);
  }
  error_ = std::max(error_, largest);
  key(pending_[to]);
}

}  // namespace taut::exporting
