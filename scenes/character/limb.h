// Arms and legs: two bones that reach a point.
#pragma once

#include "scenes/character/skeleton.h"
#include "sim/motion/types.h"

namespace taut::scenes {

// The limits of an arm.

/// How much farther (m) the hand of a performance that make_performance() made is asked to be at
/// `time` than a body that stands can bring it; 0: within its reach.
double beyond_reach(const Performance& performance, double time);

/// The two bones of a limb at rest: from its root joint to the middle one, and on to its end (m).
struct Limb {
  Vec3 upper = Vec3::Zero(), lower = Vec3::Zero();
  Vec3 bends = Vec3::Zero();  // where its end goes when it bends, if it is straight at rest

  /// The farthest that the end gets from the root without the middle joint snapping straight.
  double reach() const { return 0.998 * (upper.norm() + lower.norm()); }
};

/// Turns of the two bones (model's axes at rest to the world) and the place of the middle joint.
struct LimbTurns {
  Quat upper, lower;
  Vec3 middle;
};

/// The law of cosines in the plane through `root`, `target` and the side to which `pole` points;
/// the limb keeps the sense in which its middle joint bends at rest. A target beyond reach is
/// approached as far as the limb goes.
LimbTurns bend_limb(const Limb& limb, const Vec3& root, const Vec3& target, const Vec3& pole);

/// The part of a rotation that turns about `axis` (unit), rad in (-pi, pi].
double twist_about(const Quat& rotation, const Vec3& axis);

}  // namespace taut::scenes
