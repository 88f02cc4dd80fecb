#include "sim/contact/body_mobility.h"

#include "sim/motion/rotation.h"

namespace taut::contact {

Vec3 velocity_at(const Vec6& twist, const Vec3& arm) {
  return twist.head<3>() + twist.tail<3>().cross(arm);
}

Mat6 mobility(double inverse_mass, const Mat3& inverse_inertia) {
  Mat6 m = Mat6::Zero();
  m.topLeftCorner<3, 3>() = inverse_mass * Mat3::Identity();
  m.bottomRightCorner<3, 3>() = inverse_inertia;
  return m;
}

Mat3 mobility(const Mat6& twists, const Vec3& arm, const Vec3& pulled) {
  const Mat3 at = cross_matrix(arm), by = cross_matrix(pulled);
  return twists.topLeftCorner<3, 3>() + twists.topRightCorner<3, 3>() * by -
         at * twists.bottomLeftCorner<3, 3>() - at * twists.bottomRightCorner<3, 3>() * by;
}

void BodyMobility::set_apart(std::span<const Mat6> own) {
  own_.assign(own.begin(), own.end());
  place_.assign(own.size(), {});
  blocks_.clear();
  bodies_.clear();
}

void BodyMobility::set(std::span<const std::uint32_t> bodies, std::span<const Mat6> blocks) {
  const std::size_t count = bodies.size(), first = blocks_.size(), listed = bodies_.size();
  for (std::size_t i = 0; i < count; ++i) own_[bodies[i]] = blocks[i * count + i];
  if (count < 2) return;
  for (std::size_t i = 0; i < count; ++i) place_[bodies[i]] = {first, i, count, listed};
  blocks_.insert(blocks_.end(), blocks.begin(), blocks.end());
  bodies_.insert(bodies_.end(), bodies.begin(), bodies.end());
}

}  // namespace taut::contact
