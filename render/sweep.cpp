#include "render/sweep.h"

#include <algorithm>
#include <optional>

namespace taut {

using Eigen::Vector2f;
using Eigen::Vector3f;

Places places_of(const Item& item) {
  const Eigen::Matrix3f turn = item.model.topLeftCorner<3, 3>();
  const Vector3f at = item.model.topRightCorner<3, 1>();
  Places places;
  places.reserve(item.drawable->positions().size());
  for (const Vector3f& p : item.drawable->positions()) places.emplace_back(turn * p + at);
  return places;
}

void Sweep::add(std::span<const Item> items, double time) {
  times_.push_back(time);
  items_.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    items_[i].triangles = items[i].triangles;
    items_[i].times.push_back(places_of(items[i]));
  }
}

Sweep::Travel Sweep::find_moving(const Eigen::Matrix4f& view_projection, const Rect& viewport) {
  const Vector2f half(0.5f * float(viewport.width), 0.5f * float(viewport.height));
  const auto seen = [&](const Vector3f& p) -> std::optional<Vector2f> {
    const Eigen::Vector4f q = view_projection * p.homogeneous();
    if (q.w() < 0.05f) return {};  // behind the eye
    return half.cwiseProduct(q.head<2>() / q.w());
  };
  Travel most;
  for (Entry& entry : items_) {
    entry.is_live.assign(entry.times.front().size(), 0);
    for (std::size_t v = 0; v < entry.is_live.size(); ++v) {
      float way = 0;
      auto last = seen(entry.times.front()[v]);
      for (std::size_t k = 1; k < entry.times.size(); ++k) {
        const auto next = seen(entry.times[k][v]);
        if (last && next) {
          const float step = (*next - *last).norm();
          way += step;
          if (times_[k] > times_[k - 1])
            most.speed = std::max(most.speed, double(step) / (times_[k] - times_[k - 1]));
        }
        last = next;
      }
      entry.is_live[v] = way > float(kStill);
      most.way = std::max(most.way, double(way));
    }
    split(entry, entry.moving);
  }
  return most;
}

void Sweep::find_changing(ShadowCover& cover) {
  for (const Entry& entry : items_) cover.add(entry.moving.live, entry.times);
  std::vector<std::uint32_t> shaded;
  for (Entry& entry : items_) {
    cover.find(entry.moving.still, entry.times[entry.times.size() / 2], {}, shaded);
    for (const std::uint32_t v : shaded) entry.is_live[v] = 1;
    split(entry, entry.changing);
  }
}

void Sweep::split(const Entry& entry, Parts& parts) {
  parts.still.clear();
  parts.live.clear();
  for (std::size_t i = 0; i < entry.triangles.size(); i += 3) {
    const std::uint32_t* corner = &entry.triangles[i];
    const int live = entry.is_live[corner[0]] + entry.is_live[corner[1]] + entry.is_live[corner[2]];
    if (live < 3) parts.still.insert(parts.still.end(), corner, corner + 3);
    if (live > 0) parts.live.insert(parts.live.end(), corner, corner + 3);
  }
}

Eigen::AlignedBox3f Sweep::box(std::size_t item, std::span<const std::uint32_t> triangles) const {
  const Entry& entry = items_[item];
  Eigen::AlignedBox3f box;
  float chord = 0;
  for (const std::uint32_t v : triangles)
    for (std::size_t k = 0; k < entry.times.size(); ++k) {
      box.extend(entry.times[k][v]);
      if (k > 0) chord = std::max(chord, (entry.times[k][v] - entry.times[k - 1][v]).norm());
    }
  if (box.isEmpty()) return box;
  // A point that turns less than 50 degrees between neighbouring times strays from the chord by
  // less than an eighth of it.
  const Vector3f margin = Vector3f::Constant(chord / 8);
  return {box.min() - margin, box.max() + margin};
}

}  // namespace taut
