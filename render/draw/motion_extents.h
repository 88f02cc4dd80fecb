// Motion while the shutter is open: how exposures differ, the extent of what moves on the
// screen, and the triangles that are drawn once for all.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "render/draw/shading/drawable.h"
#include "render/draw/shading/shadow_map.h"
#include "render/picture/picture.h"
#include "scenes/scene/stage.h"
#include "sim/motion/types.h"

namespace taut::draw {

// Where the exposures of one frame differ, so that together they smooth what each shows hard:
// edges by moving the picture within a pixel, shadows by moving the light within the sun's disc.

/// Things that come up to `way` px while the shutter is open take so many exposures.
struct Exposures {
  int count;
  double way;
};

/// The exposures that a frame takes, those of its slowest things first; `way` px is how far its
/// fastest come. From one to the next things come no farther than `apart` px, as long as there are
/// as many states. The fewest are half as many as there are `samples`, no farther than 2 px apart,
/// or a thing would seem to be two. Empty: nothing needs more than one.
std::vector<Exposures> exposures(double way, int samples, int states,
                                 double apart = scenes::Stage().exposures_apart);

/// The grade, counted from 1, whose exposures show moving shadows on what is slower than they: a
/// quarter of the exposures of the fastest, at least one for each sample. Shadows have penumbras,
/// and are fainter than what throws them.
std::size_t shadow_grade(std::span<const Exposures> grades, int samples);

/// The lowest grade of what moves in the shadow map of that grade's exposures: slower things throw
/// their shadows as in the middle. Grades with more exposures than samples take turns, and share
/// one.
std::size_t casting_grade(std::span<const Exposures> grades, std::size_t grade, int samples);

/// A projection whose picture is moved by so many pixels to the right and upwards.
Eigen::Matrix4f moved_by(const Eigen::Matrix4f& view_projection, const picture::Rect& viewport,
                         const Eigen::Vector2f& pixels);

/// The projection of a picture in exposure `i`, moved by up to an eighth of a pixel: as much as
/// brings samples that the exposures share apart.
Eigen::Matrix4f moved_picture(const Eigen::Matrix4f& view_projection, const picture::Rect& viewport,
                              int i);

/// How many pictures of the scenery its mean is taken of, for a canvas with so many samples: three
/// for four, as many as software rasterisers have, since edges of what stands are seen for long.
int backdrop_pictures(int samples);

/// The projection of the scenery in one of these pictures, moved by a twelfth of a pixel or not at
/// all in the first: no two samples of the usual pattern are then in one row or column.
Eigen::Matrix4f moved_backdrop(const Eigen::Matrix4f& view_projection,
                               const picture::Rect& viewport, int i);

/// How far exposure `i` moves a look-up in the shadow map for each depth of the map beyond what
/// casts: the light comes from another point of its disc.
Eigen::Vector2f light_offset(const Eigen::Matrix4f& light_projection, int i);

/// The projection by which surfaces look shadows up in exposure `i`, if the light comes from
/// another point of its disc. Casters count as being as far along the light as `casters`: so one
/// map does for all, and shadows grow softer with their distance from there.
Eigen::Matrix4f moved_light(const Eigen::Matrix4f& light_projection, const Vec3& casters, int i);

// Which pixels things and their shadows can touch.

/// Points in space, whose hull is everything that is meant.
using HullPoints = std::vector<Eigen::Vector3f>;

void add_box(const Eigen::AlignedBox3f& box, HullPoints& hull);

/// The shadow that a box throws along `direction` on whatever lies inside `receivers`.
void add_shadow(const Eigen::AlignedBox3f& box, const Eigen::Vector3f& direction,
                const Eigen::AlignedBox3f& receivers, HullPoints& hull);

/// The pixels of `viewport` that the hull can touch; all of them where it comes behind the eye.
picture::Rect pixels(const HullPoints& hull, const Eigen::Matrix4f& projection,
                     const picture::Rect& viewport);

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
