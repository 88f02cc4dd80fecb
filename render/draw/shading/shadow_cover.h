// Which triangles of the scenery the shadows of moving things can reach.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

namespace taut::draw {

/// Where the vertices of a mesh are, m, in world space.
using Places = std::vector<Eigen::Vector3f>;

/// The cover of the casters along the key light: a coarse grid over the shadow map with the depth
/// of the nearest caster in each cell.
class ShadowCover {
 public:
  /// `light_projection` takes the world to the unit cube of the shadow map; `filter` is how far
  /// beside a caster its shadow can still be felt, in widths of the map, and `penumbra` how much
  /// farther for each depth of the map away from it.
  void start(const Eigen::Matrix4f& light_projection, float filter, float penumbra);
  /// Adds casters: triangles as indices of vertices, which are at these places at one time or at
  /// several, and anywhere between.
  void add(std::span<const std::uint32_t> triangles, std::span<const Places> times);

  /// The triangles that the shadow can reach or that meet one of the boxes, in their order, as
  /// indices of vertices. Returns the box around them.
  Eigen::AlignedBox3f find(std::span<const std::uint32_t> triangles, const Places& places,
                           std::span<const Eigen::AlignedBox3f> boxes,
                           std::vector<std::uint32_t>& indices);

 private:
  static constexpr int kCells = 96;  // a side: about 2 cm on a person
  void project(const Places& places, Places& projected) const;
  bool hides(const Places& projected, const std::uint32_t* corner) const;

  Eigen::Matrix4f projection_;
  float filter_ = 0, penumbra_ = 0;
  Eigen::AlignedBox3f covered_;  // around all casters
  std::vector<float> nearest_;
  std::vector<Places> projected_;
};

}  // namespace taut::draw
