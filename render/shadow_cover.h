// Which triangles of the scenery the shadows of moving things can reach.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "render/drawable.h"

namespace taut {

/// What the casters hide, seen along the key light: a coarse grid over the shadow map with the
/// depth of the nearest caster in each cell.
class ShadowCover {
 public:
  /// `light_projection` takes the world to the unit cube of the shadow map; `filter` is how far
  /// beside a caster its shadow can still be felt, in widths of the map.
  void start(const Eigen::Matrix4f& light_projection, float filter);
  void add(const Drawable& caster, const Eigen::Matrix4f& model);

  /// The triangles of a mesh in world space that the shadow can reach or that meet one of the
  /// boxes, in their order in the mesh, as indices of vertices. Returns the box around them.
  Eigen::AlignedBox3f find(const Drawable& mesh, std::span<const Eigen::AlignedBox3f> boxes,
                           std::vector<std::uint32_t>& indices);

 private:
  static constexpr int kCells = 96;  // a side: about 2 cm on a person
  void project(const Eigen::Matrix4f& projection, std::span<const Eigen::Vector3f> points);
  bool hides(const Eigen::AlignedBox3f& triangle) const;

  Eigen::Matrix4f projection_;
  float filter_ = 0;
  std::vector<float> nearest_;
  std::vector<Eigen::Vector3f> projected_;
};

}  // namespace taut
