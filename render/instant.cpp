#include "render/instant.h"

#include <cmath>

namespace taut {
namespace {

void move(Vec3& at, const Vec3& to, double share) {
  at += share * (to - at);
}

void move(Pose& pose, const Pose& to, double share) {
  move(pose.position, to.position, share);
  pose.rotation = pose.rotation.slerp(share, to.rotation);
}

template <typename T>
void move(std::vector<T>& all, const std::vector<T>& to, double share) {
  for (std::size_t i = 0; i < all.size(); ++i) move(all[i], to[i], share);
}

}  // namespace

Instant between(const Instant& first, const Instant& second, double share) {
  Instant result = first;
  result.state.time = std::lerp(first.state.time, second.state.time, share);
  move(result.state.connectors, second.state.connectors, share);
  move(result.state.bodies, second.state.bodies, share);
  move(result.bones, second.bones, share);
  return result;
}

}  // namespace taut
