#include "render/draw/motion_extents.h"

#include <algorithm>
#include <optional>

namespace taut::draw {

using Eigen::Vector2f;
using Eigen::Vector3f;

Places places_of(const DrawItem& item) {
  const Eigen::Matrix3f turn = item.model.topLeftCorner<3, 3>();
  const Vector3f at = item.model.topRightCorner<3, 1>();
  Places places;
  places.reserve(item.drawable->positions().size());
  for (const Vector3f& p : item.drawable->positions()) places.emplace_back(turn * p + at);
  return places;
}

void MotionExtents::add(std::span<const DrawItem> items, double time) {
  times_.push_back(time);
  items_.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    items_[i].triangles = items[i].triangles;
    items_[i].times.push_back(places_of(items[i]));
  }
}

MotionExtents::Travel MotionExtents::find_moving(const Eigen::Matrix4f& view_projection,
                                                 const picture::Rect& viewport, double still) {
  const Vector2f half(0.5f * float(viewport.width), 0.5f * float(viewport.height));
  const auto seen = [&](const Vector3f& p) -> std::optional<Vector2f> {
    const Eigen::Vector4f q = view_projection * p.homogeneous();
    if (q.w() < 0.05f) return {};  // behind the eye
    return half.cwiseProduct(q.head<2>() / q.w());
  };
  Travel most;
  for (Entry& entry : items_) {
    entry.speed.assign(entry.times.front().size(), 0);
    for (std::size_t v = 0; v < entry.speed.size(); ++v) {
      float way = 0, speed = 0;
      auto last = seen(entry.times.front()[v]);
      for (std::size_t k = 1; k < entry.times.size(); ++k) {
        const auto next = seen(entry.times[k][v]);
        if (last && next) {
          const float step = (*next - *last).norm();
          way += step;
          if (times_[k] > times_[k - 1])
            speed = std::max(speed, step / float(times_[k] - times_[k - 1]));
        }
        last = next;
      }
      if (way > float(still)) entry.speed[v] = speed;
      most.way = std::max(most.way, double(way));
      most.speed = std::max(most.speed, double(speed));
    }
  }
  return most;
}

void MotionExtents::grade(std::span<const double> speeds) {
  grades_ = int(speeds.size()) + 2;
  for (Entry& entry : items_) {
    entry.moves.clear();
    for (const float speed : entry.speed) {
      const auto above = std::ranges::lower_bound(speeds, double(speed)) - speeds.begin();
      entry.moves.push_back(speed > 0 ? std::uint8_t(1 + above) : std::uint8_t(0));
    }
    entry.shows = entry.moves;
  }
}

namespace {

/// The lowest and the highest grade of a triangle's corners.
std::pair<int, int> grades(const std::vector<std::uint8_t>& of, const std::uint32_t* corner) {
  return std::minmax({int(of[corner[0]]), int(of[corner[1]]), int(of[corner[2]])});
}

void append(Triangles& triangles, const std::uint32_t* corner) {
  triangles.insert(triangles.end(), corner, corner + 3);
}

}  // namespace

void MotionExtents::shade(ShadowCover& cover, int grade) {
  Triangles some, shaded;
  bool any = false;
  for (const Entry& entry : items_) {
    some.clear();
    for (std::size_t i = 0; i < entry.triangles.size(); i += 3)
      if (grades(entry.moves, &entry.triangles[i]).second == grade)
        append(some, &entry.triangles[i]);
    cover.add(some, entry.times);
    any |= !some.empty();
  }
  if (!any) return;
  for (Entry& entry : items_) {
    some.clear();
    for (std::size_t i = 0; i < entry.triangles.size(); i += 3)
      if (grades(entry.shows, &entry.triangles[i]).first < grade) append(some, &entry.triangles[i]);
    cover.find(some, entry.times[entry.times.size() / 2], {}, shaded);
    for (const std::uint32_t v : shaded)
      entry.shows[v] = std::max(entry.shows[v], std::uint8_t(grade));
  }
}

void MotionExtents::divide() {
  for (Entry& entry : items_) {
    entry.standing.clear();
    entry.moving.clear();
    entry.shown.assign(std::size_t(grades_), {});
    for (std::size_t i = 0; i < entry.triangles.size(); i += 3) {
      const std::uint32_t* corner = &entry.triangles[i];
      const auto [low, high] = grades(entry.moves, corner);
      if (low == 0) append(entry.standing, corner);
      if (high > 0) append(entry.moving, corner);
      const auto [first, last] = grades(entry.shows, corner);
      for (int grade = first; grade <= last; ++grade)
        append(entry.shown[std::size_t(grade)], corner);
    }
  }
}

Eigen::AlignedBox3f MotionExtents::box(std::size_t item,
                                       std::span<const std::uint32_t> triangles) const {
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

}  // namespace taut::draw
