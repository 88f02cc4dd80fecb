// Where the exposures of one frame differ, so that together they smooth what each shows hard:
// edges by moving the picture within a pixel, shadows by moving the light within the sun's disc.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "render/picture/rect.h"
#include "scenes/scene/stage.h"
#include "sim/motion/types.h"

namespace taut::draw {

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

}  // namespace taut::draw
