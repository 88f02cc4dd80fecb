// What moves while the shutter is open: how far, and what of it can be drawn once for all.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "render/draw/draw_item.h"
#include "render/draw/shadow_cover.h"
#include "render/picture/rect.h"

namespace taut::draw {

/// Triangles, as indices of vertices.
using Triangles = std::vector<std::uint32_t>;

/// The same items at a few times, the frame's own in the middle. Vertices have grades by how far
/// they move: 0 those that stand still. A triangle belongs to the grades of all its corners and to
/// those between, so that no crack opens between parts.
class MotionExtents {
 public:
  /// px that a vertex may move and still count as still.
  static constexpr double kStill = 1;

  void clear() {
    items_.clear();
    times_.clear();
  }
  /// The items at one more, later time (s).
  void add(std::span<const DrawItem> items, double time);

  struct Travel {
    double way = 0;    // px that the fastest vertex comes
    double speed = 0;  // px/s, the largest of any vertex between two neighbouring times
  };
  /// Finds what moves: farther than `still` px.
  Travel find_moving(const Eigen::Matrix4f& view_projection, const picture::Rect& viewport,
                     double still = kStill);
  /// Grades what moves: 1, and one more for each of the rising speeds (px/s) that a vertex exceeds.
  void grade(std::span<const double> speeds);
  /// What moves with this grade changes how it shades other things: these are shown with at least
  /// that grade. To be called for every grade above 0, the highest first; `cover` has been started,
  /// and afterwards it also holds what moves with this grade.
  void shade(ShadowCover& cover, int grade);
  /// Divides triangles by what was found.
  void divide();

  /// Of an item: what does not move, and what moves.
  const Triangles& standing(std::size_t item) const { return items_[item].standing; }
  const Triangles& moving(std::size_t item) const { return items_[item].moving; }
  /// Of an item: what is shown with this grade, as it moves so or is shaded by what does.
  const Triangles& shown(std::size_t item, int grade) const {
    return items_[item].shown[std::size_t(grade)];
  }
  /// Around what moves of an item, at all times.
  Eigen::AlignedBox3f moving_box(std::size_t item) const { return box(item, moving(item)); }
  /// Around the given triangles of an item at all times.
  Eigen::AlignedBox3f box(std::size_t item, std::span<const std::uint32_t> triangles) const;

 private:
  struct Entry {
    std::span<const std::uint32_t> triangles;
    std::vector<Places> times;
    std::vector<float> speed;                // [vertex], px/s; 0: it stands still
    std::vector<std::uint8_t> moves, shows;  // [vertex], grades
    Triangles standing, moving;
    std::vector<Triangles> shown;  // [grade]
  };

  std::vector<Entry> items_;
  std::vector<double> times_;  // s
  int grades_ = 0;             // how many, 0 included
};

/// Where the vertices of an item are.
Places places_of(const DrawItem& item);

}  // namespace taut::draw
