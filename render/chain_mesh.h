// A chain: real links between two swivels.
#pragma once

#include "render/link_frames.h"
#include "render/pieces.h"

namespace taut {

class ChainMesh final : public ConnectorMesh {
 public:
  ChainMesh(const Connector& connector, const ConnectorLook& look,
            std::span<const std::shared_ptr<const Model>> bodies);

  void place(std::span<const Vec3> particles, std::span<const Pose> bodies,
             std::vector<MovingVertex>& vertices) const override;

 private:
  /// The body that holds an end, the direction out of it, in its frame, and how thick it is there.
  struct Mount {
    std::size_t body;
    Vec3 axis;
    double radius;  // m; 0: it has no model
  };
  static std::optional<Mount> mount_at(const Connector& connector, std::size_t particle,
                                       std::span<const std::shared_ptr<const Model>> bodies);
  void add(const Piece& piece, const Eigen::Vector3f& color);
  /// The eye that the end's link hangs in (at right angles to the link) and the collar below it;
  /// `outwards` is the link's direction away from the mount, `wide` its wide side.
  void put_swivel(const Mount& mount, const Vec3& point, const Vec3& outwards, const Vec3& wide,
                  std::span<const Pose> bodies, std::vector<MovingVertex>& vertices) const;

  std::array<std::optional<Mount>, 2> mounts_;
  std::size_t links_ = 0;
  double width_ = 0, pitch_ = 0, inset_ = 0;  // m
  Piece link_, ring_, collar_;
};

}  // namespace taut
