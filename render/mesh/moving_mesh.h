// Geometry whose triangles stay while its vertices move.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sim/motion/types.h"

namespace taut::mesh {

/// A vertex that moves every frame.
struct MovingVertex {
  Eigen::Vector3f position, normal;
};

/// A vertex's part that never changes: where the surface pattern is, and the tint.
struct RestVertex {
  Eigen::Vector3f rest;
  Eigen::Vector3f color;
};

/// Geometry of one connector, whose triangles never change while its vertices follow the particles.
/// Everything is placed by the share of the connector's length, never by measured distances, so
/// that nothing pops in or out when it snaps taut or is stretched by its method.
class ConnectorMesh {
 public:
  virtual ~ConnectorMesh() = default;

  const std::vector<std::uint32_t>& indices() const { return indices_; }
  const std::vector<RestVertex>& rest() const { return rest_; }
  /// Both, for one who keeps them elsewhere; none are here afterwards.
  std::pair<std::vector<std::uint32_t>, std::vector<RestVertex>> take_shape() {
    return {std::move(indices_), std::move(rest_)};
  }
  /// The vertices for these particles (m, world) and the frames of the bodies.
  virtual void place(std::span<const Vec3> particles, std::span<const Pose> bodies,
                     std::vector<MovingVertex>& vertices) const = 0;

 protected:
  std::vector<std::uint32_t> indices_;
  std::vector<RestVertex> rest_;
};

}  // namespace taut::mesh
