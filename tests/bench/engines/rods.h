// A hanging connector as engines can have it: rigid rods with inertia in place of massless links.
#pragma once

#include <optional>
#include <vector>

#include "sim/world/world.h"

namespace taut::engines {

/// One link. The point masses at its ends make it a dumbbell: its moment of inertia across itself
/// is exactly theirs. About itself it has none and nothing turns it, so that any moment there
/// leaves the motion as it is; with the same one about all axes a rod looks alike from everywhere.
struct Rod {
  Vec3 along = Vec3::Zero();  // m, from its upper to its lower end, at the start
  double centre = 0;          // of mass, as a share of `along`
  double mass = 0;            // kg
  double inertia = 0;         // kg m^2, about the centre, any axis
  Vec3 spin = Vec3::Zero();   // rad/s, at the start; none about itself
  // Of the bend between it and what is above it (material::BendElement).
  double bending_stiffness = 0;  // N m
  double bending_damping = 0;    // N m s
};

/// The load that hangs from the last rod by a point: its axes are the world's at the start.
struct Load {
  double mass = 0;              // kg
  Vec3 centre = Vec3::Zero();   // m, from the point
  Mat3 inertia = Mat3::Zero();  // kg m^2, about the centre
  Vec3 spin = Vec3::Zero();     // rad/s, at the start
  BodyCapsule capsule;          // that touches obstacles; m, from the point
};

/// A ball about one end of a rod: a particle that obstacles touch.
struct Bead {
  std::size_t rod = 0;
  Vec3 at = Vec3::Zero();  // m, from the rod's centre of mass
};

/// The one connector of a world, from a fixed, driven or free end down to a point mass, a free end
/// or a free body. Places and speeds are relative to where it hangs from: an end that is driven is
/// a frame that falls, in which gravity is less by the end's acceleration. One that is free is
/// where it was at the start. It may resist bending, clamped to a fixed point or to nothing; then
/// nothing twists it.
class Rods {
 public:
  /// Throws std::invalid_argument with the reason where the world is another.
  explicit Rods(const World& world);

  const std::vector<Rod>& rods() const { return rods_; }
  const std::optional<Load>& load() const { return load_; }
  /// Whether the upper end is held; otherwise it moves by `velocity` (m/s) at the start.
  bool hangs() const { return hangs_; }
  const Vec3& velocity() const { return velocity_; }

  /// Whether any rod resists bending.
  bool resist_bending() const;
  /// The direction in which the upper end is clamped (unit vector), or zero.
  const Vec3& clamp() const { return clamp_; }
  /// The moments (N m) of taut's own model in the joints above the rods, where the rods have these
  /// edges (m) and spins (rad/s): of the couples on each rod and on all that hang from it.
  void bend(const std::vector<Vec3>& edges, const std::vector<Vec3>& spins,
            std::vector<Vec3>& moments) const;

  /// That beads and the load touch, in the world's places.
  const std::vector<Obstacle>& obstacles() const { return obstacles_; }
  /// The motion of one of them in the rods' frame.
  FrameMotion motion(const Obstacle& obstacle, const World& world, double time) const;
  std::vector<Bead> beads() const;
  double radius() const { return radius_; }  // m, of the beads
  /// m/s^2, as what hangs feels it at `time`.
  Vec3 gravity(const World& world, double time) const;
  /// Puts the world at `time`: `ends` are the upper end of the first rod and the rods' lower ends
  /// (m), `turn` the load's rotation since the start.
  void place(const std::vector<Vec3>& ends, const Quat& turn, double time, World& world) const;

 private:
  std::vector<Rod> rods_;
  std::optional<Load> load_;
  bool hangs_ = true;
  Vec3 velocity_ = Vec3::Zero(), start_ = Vec3::Zero(), clamp_ = Vec3::Zero();
  std::vector<Obstacle> obstacles_;
  double radius_ = 0;
  std::size_t body_ = 0;
  Quat at_start_ = Quat::Identity();  // of the body
};

}  // namespace taut::engines
