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
};

/// What hangs from the last rod by a point: its axes are the world's at the start.
struct Load {
  double mass = 0;              // kg
  Vec3 centre = Vec3::Zero();   // m, from the point
  Mat3 inertia = Mat3::Zero();  // kg m^2, about the centre
  Vec3 spin = Vec3::Zero();     // rad/s, at the start
};

/// The one connector of a world, from a fixed or driven point down to a point mass, a free end or a
/// free body. Places and speeds are relative to where it hangs from: an end that is driven is a
/// frame that falls, in which gravity is less by the end's acceleration.
class Rods {
 public:
  /// Throws std::invalid_argument with the reason where the world is another.
  explicit Rods(const World& world);

  const std::vector<Rod>& rods() const { return rods_; }
  const std::optional<Load>& load() const { return load_; }
  /// m/s^2, as what hangs feels it at `time`.
  Vec3 gravity(const World& world, double time) const;
  /// Puts the world at `time`: `ends` are the rods' lower ends (m), `turn` the load's rotation
  /// since the start.
  void place(const std::vector<Vec3>& ends, const Quat& turn, double time, World& world) const;

 private:
  std::vector<Rod> rods_;
  std::optional<Load> load_;
  std::size_t body_ = 0;
  Quat at_start_ = Quat::Identity();  // of the body
};

}  // namespace taut::engines
