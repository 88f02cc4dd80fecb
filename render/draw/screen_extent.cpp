#include "render/draw/screen_extent.h"

#include <cmath>

namespace taut::draw {
namespace {

Eigen::Vector3f corner(const Eigen::AlignedBox3f& box, int i) {
  return box.corner(Eigen::AlignedBox3f::CornerType(i));
}

}  // namespace

void add_box(const Eigen::AlignedBox3f& box, HullPoints& hull) {
  if (box.isEmpty()) return;
  for (int i = 0; i < 8; ++i) hull.push_back(corner(box, i));
}

void add_shadow(const Eigen::AlignedBox3f& box, const Eigen::Vector3f& direction,
                const Eigen::AlignedBox3f& receivers, HullPoints& hull) {
  if (box.isEmpty() || receivers.isEmpty()) return;
  // Between two sides of the receivers the shadow is a slanted prism; the sides that light takes
  // the shortest way between make the smallest.
  int axis = 0;
  (receivers.sizes().array() / direction.array().abs().max(1e-6f)).minCoeff(&axis);
  if (std::abs(direction[axis]) < 1e-6f) return add_box(receivers, hull);
  for (const float side : {receivers.min()[axis], receivers.max()[axis]})
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3f from = corner(box, i);
      hull.push_back(from + std::max((side - from[axis]) / direction[axis], 0.0f) * direction);
    }
}

picture::Rect pixels(const HullPoints& hull, const Eigen::Matrix4f& projection,
                     const picture::Rect& viewport) {
  Eigen::AlignedBox2f box;
  for (const Eigen::Vector3f& p : hull) {
    const Eigen::Vector4f q = projection * p.homogeneous();
    if (q.w() < 0.05f) return viewport;
    box.extend(Eigen::Vector2f(q.head<2>() / q.w()));
  }
  if (box.isEmpty()) return {viewport.x, viewport.y, 0, 0};
  // A pixel more all round: samples lie off the pixels' centres.
  const auto pixel = [](float at, int size, int more) {
    const float share = 0.5f + 0.5f * std::clamp(at, -2.0f, 2.0f);
    return std::clamp(int(std::floor(share * float(size))) + more, 0, size);
  };
  const int left = pixel(box.min().x(), viewport.width, -1);
  const int right = pixel(box.max().x(), viewport.width, 2);
  const int low = pixel(box.min().y(), viewport.height, -1);
  const int high = pixel(box.max().y(), viewport.height, 2);
  return {viewport.x + left, viewport.y + low, right - left, high - low};
}

}  // namespace taut::draw
