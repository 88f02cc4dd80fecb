// A chain: real links between two swivels.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/mesh/link_frames.h"
#include "render/mesh/moving_mesh.h"
#include "render/mesh/pieces.h"
#include "scenes/scene/stage.h"
#include "sim/world/connector.h"

namespace taut::mesh {

/// The shape of a chain.
struct ChainShape {
  std::size_t links;
  double width;  // of a link, outside, m
  double pitch;  // from one link to the next, m
  double inset;  // of a swivel's eye, from where the first link begins, m
  Piece link, ring, collar;
};
ChainShape chain_shape(double length, double width);

/// The body that holds an end of a chain, the direction out of it, in its frame, and how thick it
/// is there.
struct ChainMount {
  std::size_t body;
  Vec3 axis;
  double radius;  // m; 0: it has no model
};
std::optional<ChainMount> chain_mount(const Connector& connector, std::size_t particle,
                                      std::span<const std::shared_ptr<const scenes::Model>> bodies);

class ChainMesh final : public ConnectorMesh {
 public:
  ChainMesh(const Connector& connector, const scenes::ConnectorLook& look,
            std::span<const std::shared_ptr<const scenes::Model>> bodies);

  void place(std::span<const Vec3> particles, std::span<const Pose> bodies,
             std::vector<MovingVertex>& vertices) const override;

 private:
  void add(const Piece& piece, const Eigen::Vector3f& color);
  /// The eye that the end's link hangs in (at right angles to the link) and the collar below it;
  /// `outwards` is the link's direction away from the mount, `wide` its wide side.
  void put_swivel(const ChainMount& mount, const Vec3& point, const Vec3& outwards,
                  const Vec3& wide, std::span<const Pose> bodies,
                  std::vector<MovingVertex>& vertices) const;

  std::array<std::optional<ChainMount>, 2> mounts_;
  ChainShape shape_;
};

}  // namespace taut::mesh
