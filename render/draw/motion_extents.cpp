#include "render/draw/motion_extents.h"

#include <algorithm>
#include <optional>

namespace taut::draw {

using Eigen::Vector2f;
using Eigen::Vector3f;

void MotionExtents::start(std::span<const DrawItem> items, std::vector<double> times,
                          PlacesAt places) {
  times_ = std::move(times);
  places_ = std::move(places);
  at_.resize(times_.size());
  at_item_ = items.size();
  items_.clear();
  items_.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) items_[i].triangles = items[i].triangles;
}

const std::vector<Places>& MotionExtents::places(std::size_t item) {
  if (at_item_ != item)
    for (std::size_t k = 0; k < at_.size(); ++k) places_(k, item, at_[k]);
  at_item_ = item;
  return at_;
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
  for (std::size_t i = 0; i < items_.size(); ++i) {
    Entry& entry = items_[i];
    const std::vector<Places>& at = places(i);
    entry.speed.assign(at.front().size(), 0);
    for (std::size_t v = 0; v < entry.speed.size(); ++v) {
      float way = 0, speed = 0;
      auto last = seen(at.front()[v]);
      for (std::size_t k = 1; k < at.size(); ++k) {
        const auto next = seen(at[k][v]);
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
    entry.swept_below.assign(entry.moves.size(), 0);
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

void MotionExtents::sweep(ShadowCover& cover, int grade, int below) {
  Triangles some, swept;
  bool any = false;
  for (std::size_t item = 0; item < items_.size(); ++item) {
    const Entry& entry = items_[item];
    some.clear();
    for (std::size_t i = 0; i < entry.triangles.size(); i += 3)
      if (grades(entry.moves, &entry.triangles[i]).second == grade)
        append(some, &entry.triangles[i]);
    if (some.empty()) continue;
    cover.add(some, places(item));
    any = true;
  }
  if (!any) return;
  for (std::size_t item = 0; item < items_.size(); ++item) {
    Entry& entry = items_[item];
    some.clear();
    for (std::size_t i = 0; i < entry.triangles.size(); i += 3)
      if (grades(entry.moves, &entry.triangles[i]).first < below) append(some, &entry.triangles[i]);
    if (some.empty()) continue;
    cover.find(some, places(item)[times_.size() / 2], {}, swept);
    for (const std::uint32_t v : swept)
      entry.swept_below[v] = std::max(entry.swept_below[v], std::uint8_t(below));
  }
}

/// The triangles whose corners are chosen.
template <typename Chosen>
MotionExtents::Subset MotionExtents::subset(std::span<const std::uint32_t> triangles,
                                            Chosen chosen) {
  std::size_t count = 0;  // of indices
  for (std::size_t i = 0; i < triangles.size(); i += 3) count += chosen(&triangles[i]) ? 3 : 0;
  if (count == triangles.size()) return {.some = {}, .all = true};
  Subset subset;
  subset.some.reserve(count);
  for (std::size_t i = 0; i < triangles.size(); i += 3)
    if (chosen(&triangles[i])) append(subset.some, &triangles[i]);
  return subset;
}

void MotionExtents::divide() {
  const int highest = grades_ - 1;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    Entry& entry = items_[i];
    for (std::vector<Subset>* subsets : {&entry.casting, &entry.moving, &entry.plain, &entry.swept})
      subsets->clear();
    entry.casting_boxes.clear();
    for (int grade = 0; grade <= highest; ++grade) {
      // With a corner of a grade in that range, or on both sides of it.
      const auto moves = [&](const std::uint32_t* corner, int to) {
        const auto [low, high] = grades(entry.moves, corner);
        return low <= to && high >= grade;
      };
      const auto swept = [&](const std::uint32_t* corner) {
        return grades(entry.swept_below, corner).second > grade;
      };
      const auto add = [&](std::vector<Subset>& subsets, auto chosen) {
        subsets.push_back(subset(entry.triangles, chosen));
      };
      using Corner = const std::uint32_t*;
      add(entry.casting, [&](Corner c) { return moves(c, grade); });
      add(entry.moving, [&](Corner c) { return moves(c, highest); });
      add(entry.plain, [&](Corner c) { return moves(c, grade) && !swept(c); });
      add(entry.swept, [&](Corner c) { return moves(c, grade) && swept(c); });
      entry.casting_boxes.push_back(grade > 0 ? box(i, entry.casting.back())
                                              : Eigen::AlignedBox3f());
    }
    entry.moving_box = box(i, entry.moving[1]);
    entry.speed = {};
  }
  places_ = {};
}

Eigen::AlignedBox3f MotionExtents::box(std::size_t item, const Subset& subset) {
  Eigen::AlignedBox3f box;
  const std::span<const std::uint32_t> triangles = subset.of(items_[item].triangles);
  if (triangles.empty()) return box;
  const std::vector<Places>& at = places(item);
  float chord = 0;
  for (const std::uint32_t v : triangles)
    for (std::size_t k = 0; k < at.size(); ++k) {
      box.extend(at[k][v]);
      if (k > 0) chord = std::max(chord, (at[k][v] - at[k - 1][v]).norm());
    }
  // A point that turns less than 50 degrees between neighbouring times strays from the chord by
  // less than an eighth of it.
  const Vector3f margin = Vector3f::Constant(chord / 8);
  return {box.min() - margin, box.max() + margin};
}

}  // namespace taut::draw
