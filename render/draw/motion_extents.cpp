#include "render/draw/motion_extents.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "render/draw/shading/lighting.h"

namespace taut::draw {
namespace {

constexpr double kSeenTwice = 2;  // px: farther apart, two exposures look like two things

/// The i-th point of a sequence that fills the unit square evenly however far it goes: multiples of
/// the reciprocals of the plastic number (Roberts 2018).
Eigen::Vector2f point(int i) {
  constexpr double kPlastic = 1.32471795724474602596;
  const auto part = [&](double step) {
    const double x = 0.5 + step * i;
    return float(x - std::floor(x));
  };
  return {part(1 / kPlastic), part(1 / (kPlastic * kPlastic))};
}

}  // namespace

Eigen::Matrix4f moved_by(const Eigen::Matrix4f& view_projection, const picture::Rect& viewport,
                         const Eigen::Vector2f& pixels) {
  Eigen::Matrix4f moved = view_projection;
  moved.row(0) += 2 * pixels.x() / float(viewport.width) * view_projection.row(3);
  moved.row(1) += 2 * pixels.y() / float(viewport.height) * view_projection.row(3);
  return moved;
}

std::vector<Exposures> exposures(double way, int samples, int states, double apart) {
  std::vector<Exposures> result;
  const auto enough = [&] { return !result.empty() && result.back().way >= way; };
  if (const int count = samples / 2; count > 1 && count <= states)
    result.push_back({count, count * std::min(apart, kSeenTwice)});
  if (samples > 1 && samples <= states && !enough()) result.push_back({samples, samples * apart});
  int most = samples;
  while (most * apart < way && 2 * most <= states) most *= 2;
  if (most > 2 * samples) result.push_back({2 * samples, 2 * samples * apart});
  if (most > samples) result.push_back({most, most * apart});
  return result;
}

std::size_t shadow_grade(std::span<const Exposures> grades, int samples) {
  std::size_t grade = 1;
  const int enough = std::max(samples, grades.back().count / 4);
  while (grade < grades.size() && grades[grade - 1].count < enough) ++grade;
  return grade;
}

std::size_t casting_grade(std::span<const Exposures> grades, std::size_t grade, int samples) {
  while (grade > 1 && grades[grade - 2].count > samples) --grade;
  return grade;
}

int backdrop_pictures(int samples) {
  return samples == 4 ? 3 : 1;
}

Eigen::Matrix4f moved_backdrop(const Eigen::Matrix4f& view_projection,
                               const picture::Rect& viewport, int i) {
  // Four samples are a quarter of a pixel apart both ways: a third of that makes twelve even rows.
  constexpr float kStep[] = {0, -1.0f / 12, 1.0f / 12};
  return moved_by(view_projection, viewport, {kStep[i], -kStep[i]});
}

Eigen::Matrix4f moved_picture(const Eigen::Matrix4f& view_projection, const picture::Rect& viewport,
                              int i) {
  return moved_by(view_projection, viewport, 0.25f * (point(i).array() - 0.5f));
}

Eigen::Vector2f light_offset(const Eigen::Matrix4f& light_projection, int i) {
  const Eigen::Vector2f p = point(i);
  const float turn = 2 * std::numbers::pi_v<float> * p.x(), out = kSun * std::sqrt(p.y());
  const float metre = light_projection.row(2).head<3>().norm();  // in depths of the map
  return out / metre *
         Eigen::Vector2f(std::cos(turn) * light_projection.row(0).head<3>().norm(),
                         std::sin(turn) * light_projection.row(1).head<3>().norm());
}

Eigen::Matrix4f moved_light(const Eigen::Matrix4f& light_projection, const Vec3& casters, int i) {
  const Eigen::Vector2f offset = light_offset(light_projection, i);
  Eigen::RowVector4f beyond = light_projection.row(2);  // of a point, in depths of the map
  beyond.w() -= light_projection.row(2).dot(casters.cast<float>().homogeneous());
  Eigen::Matrix4f moved = light_projection;
  for (int k = 0; k < 2; ++k) moved.row(k) += offset[k] * beyond;
  return moved;
}

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
