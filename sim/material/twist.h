// Twist of a connector between clamps, which is the same all along it, as an element of a world.
#pragma once

#include <cstdint>

#include "sim/material/elements.h"

namespace taut::material {

/// A connector that is clamped at both ends, or a closed loop, and resists twist. Waves of twist
/// run away from what moves the rod so fast that the moment is the same everywhere (Bergou and
/// others, Discrete elastic rods, SIGGRAPH 2008, section 7.2): only the twist of the whole counts,
/// and its energy is stiffness twist^2 / 2.
struct TwistElement {
  std::uint32_t connector = 0, first = 0, links = 0;  // `first`: its first particle's point
  bool closed = false;                                // a loop, without clamps
  std::uint32_t from = 0, to = 0;                     // indices of the clamps
  double stiffness = 0;                               // N m: one over the sum of length / GJ
  double damping = 0;                                 // N m s
  double rest = 0;                                    // rad
  double most = 0;                                    // rad: how far its ends are turned at most
  double start = 0;  // rad: how far they were, carried along, where it was not twisted
  double since = 0;  // rad: what has come to that by the last state that was followed
};

/// By what a frame turns about its direction that is carried from an edge (m) to the next, as these
/// change: how much of the twist between two frames is less. The angle itself depends on what it is
/// measured from, its derivatives do not.
class Carry {
 public:
  Carry(const Vec3& e0, const Vec3& e1);

  /// t0 x t1 / (1 + t0 . t1), t0 and t1 the directions: divided by the length of an edge, the
  /// derivative of the twist by that edge, rad/m.
  const Vec3& slope() const { return slope_; }
  /// The second derivatives of the twist, rad/m^2, those by one edge less an antisymmetric part: it
  /// cancels against that of the carry on the edge's other side.
  Bend::Stiffness second() const;

 private:
  double inverse0_, inverse1_;  // 1/m
  Vec3 t0_, t1_;
  double share_;  // 1 / (1 + t0 . t1)
  Vec3 slope_;
};

}  // namespace taut::material
