// Motion while the shutter is open: its extent, and the triangles that can be drawn once for all.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "render/draw/shading/draw_item.h"
#include "render/draw/shading/shadow_cover.h"
#include "render/picture/rect.h"

namespace taut::draw {

/// Triangles, as indices of vertices.
using Triangles = std::vector<std::uint32_t>;

/// Items at a few times, the frame's own in the middle. Vertices have grades by how far
/// they move: 0 those that stand still. A triangle belongs to the grades of all its corners and to
/// those between, so that no crack opens between parts.
class MotionExtents {
 public:
  /// px that a vertex may move and still count as still.
  static constexpr double kStill = 1;

  /// Tells where the vertices of an item are, by the index of the time and the item's. Asked for
  /// again and again: to keep them all would take more than the meshes.
  using PlacesAt = std::function<void(std::size_t time, std::size_t item, Places& places)>;

  /// Begins: the triangles of items that never change, and the times (s, rising). `places` must
  /// work until the triangles are divided.
  void start(std::span<const DrawItem> items, std::vector<double> times, PlacesAt places);

  struct Travel {
    double way = 0;    // px that the fastest vertex comes
    double speed = 0;  // px/s, the largest of any vertex between two neighbouring times
  };
  /// Finds what moves: farther than `still` px.
  Travel find_moving(const Eigen::Matrix4f& view_projection, const picture::Rect& viewport,
                     double still = kStill);
  /// Grades what moves: 1, and one more for each of the rising speeds (px/s) that a vertex exceeds.
  void grade(std::span<const double> speeds);
  /// Finds the triangles of grades below `below` that are swept: by the shadows of triangles that
  /// move with `grade` or a higher one. To be called for every grade above 0, the highest first;
  /// `cover` has been started, and afterwards also holds the triangles that move with this grade.
  void sweep(ShadowCover& cover, int grade, int below);
  /// Divides triangles by what was found.
  void divide();

  /// Of an item: the triangles that move with this grade, and those that do with it or a higher
  /// one.
  std::span<const std::uint32_t> casting(std::size_t item, int grade) const {
    return items_[item].casting[std::size_t(grade)].of(items_[item].triangles);
  }
  std::span<const std::uint32_t> moving(std::size_t item, int grade) const {
    return items_[item].moving[std::size_t(grade)].of(items_[item].triangles);
  }
  /// Of an item: the triangles that move with this grade and are not swept, and those that are.
  std::span<const std::uint32_t> plain(std::size_t item, int grade) const {
    return items_[item].plain[std::size_t(grade)].of(items_[item].triangles);
  }
  std::span<const std::uint32_t> swept(std::size_t item, int grade) const {
    return items_[item].swept[std::size_t(grade)].of(items_[item].triangles);
  }
  /// Around what moves of an item, at all times.
  const Eigen::AlignedBox3f& moving_box(std::size_t item) const { return items_[item].moving_box; }
  /// Around what of an item moves with this grade above 0, at all times.
  const Eigen::AlignedBox3f& casting_box(std::size_t item, int grade) const {
    return items_[item].casting_boxes[std::size_t(grade)];
  }

 private:
  /// Some of an item's triangles; all are no copy: a thousand ropes that move would take as much
  /// again as their meshes.
  struct Subset {
    Triangles some;
    bool all = false;

    std::span<const std::uint32_t> of(std::span<const std::uint32_t> triangles) const {
      return all ? triangles : some;
    }
  };
  struct Entry {
    std::span<const std::uint32_t> triangles;
    std::vector<float> speed;                           // [vertex], px/s; 0: it stands still
    std::vector<std::uint8_t> moves;                    // [vertex], grades
    std::vector<std::uint8_t> swept_below;              // [vertex], the grade; 0: not swept
    std::vector<Subset> casting, moving, plain, swept;  // [grade]
    Eigen::AlignedBox3f moving_box;
    std::vector<Eigen::AlignedBox3f> casting_boxes;  // [grade]
  };
  template <typename Chosen>
  static Subset subset(std::span<const std::uint32_t> triangles, Chosen chosen);
  const std::vector<Places>& places(std::size_t item);
  Eigen::AlignedBox3f box(std::size_t item, const Subset& subset);

  std::vector<Entry> items_;
  std::vector<double> times_;  // s
  PlacesAt places_;
  std::vector<Places> at_;  // [time], of the last item asked for
  std::size_t at_item_ = 0;
  int grades_ = 0;  // how many, 0 included
};

}  // namespace taut::draw
