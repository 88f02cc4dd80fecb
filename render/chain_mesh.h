// A chain: real links between two swivels.
#pragma once

#include "render/link_frames.h"
#include "render/pieces.h"

namespace taut {

class ChainMesh final : public ConnectorMesh {
 public:
  ChainMesh(const Connector& connector, const ConnectorLook& look);

  void place(std::span<const Vec3> particles, std::span<const Pose> bodies,
             std::vector<MovingVertex>& vertices) const override;

 private:
  /// The body that holds an end, and the direction out of it, in its frame.
  struct Mount {
    std::size_t body;
    Vec3 axis;
  };
  static std::optional<Mount> mount_at(const Connector& connector, std::size_t particle);
  void add(const Piece& piece, const Eigen::Vector3f& color);
  /// The eye that the end's link hangs in (at right angles to the link) and the collar below it;
  /// `outwards` is the link's direction away from the mount, `wide` its wide side.
  void put_swivel(const Mount& mount, const Vec3& point, const Vec3& outwards, const Vec3& wide,
                  std::span<const Pose> bodies, std::vector<MovingVertex>& vertices) const;

  std::array<std::optional<Mount>, 2> mounts_;
  std::size_t links_ = 0;
  double pitch_ = 0, inset_ = 0;  // m
  Piece link_, ring_, collar_;
};

}  // namespace taut
