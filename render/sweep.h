// What moves while the shutter is open: how far, and what of it can be drawn once for all.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "render/item.h"
#include "render/rect.h"
#include "render/shadow_cover.h"

namespace taut {

/// Triangles (indices of vertices) in two parts. Those on the border, with corners in both, belong
/// to both parts, so that no crack opens between them.
struct Parts {
  std::vector<std::uint32_t> still, live;
};

/// The same items at a few times, the frame's own in the middle.
class Sweep {
 public:
  /// px that a vertex may move and still count as still.
  static constexpr double kStill = 1;

  void clear() {
    items_.clear();
    times_.clear();
  }
  /// The items at one more, later time (s).
  void add(std::span<const Item> items, double time);

  struct Travel {
    double way = 0;    // px that the fastest vertex comes
    double speed = 0;  // px/s, the largest of any vertex between two neighbouring times
  };
  /// Finds what moves.
  Travel find_moving(const Eigen::Matrix4f& view_projection, const Rect& viewport);
  /// Finds what looks different from time to time: what moves, and what that may shade. `cover` has
  /// been started; afterwards it holds what moves.
  void find_changing(ShadowCover& cover);

  /// Of an item: what moves is live.
  const Parts& moving(std::size_t item) const { return items_[item].moving; }
  /// Of an item: what looks different is live.
  const Parts& changing(std::size_t item) const { return items_[item].changing; }
  /// Around the given triangles of an item at all times.
  Eigen::AlignedBox3f box(std::size_t item, std::span<const std::uint32_t> triangles) const;

 private:
  struct Entry {
    std::span<const std::uint32_t> triangles;
    std::vector<Places> times;
    std::vector<char> is_live;  // [vertex]
    Parts moving, changing;
  };
  static void split(const Entry& entry, Parts& parts);

  std::vector<Entry> items_;
  std::vector<double> times_;  // s
};

/// Where the vertices of an item are.
Places places_of(const Item& item);

}  // namespace taut
