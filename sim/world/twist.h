// Twist of connectors: frames that are carried along them, and what their ends are turned by.
#pragma once

#include "sim/world/state.h"

namespace taut {

/// Carries a frame from one direction to the next by the smallest rotation that takes the one to
/// the other, so that it never turns about them (Bishop, There is more than one way to frame a
/// curve, 1975, in steps as Bergou and others, Discrete elastic rods, 2008). Directions are unit
/// vectors; the x axis of a frame is its direction.
class CarriedFrame {
 public:
  CarriedFrame(const Quat& frame, const Vec3& direction) : frame_(frame), direction_(direction) {}

  void carry(const Vec3& direction);
  /// How far another frame there is turned against it about the direction, rad, from -pi to pi.
  double turn_to(const Quat& frame) const;

 private:
  Quat frame_;
  Vec3 direction_;
};

/// Some frame whose x axis is a direction (unit vector); near directions have near frames but where
/// x changes its sign.
Quat frame_along(const Vec3& direction);

/// Whether the connector is a closed loop: its first and last particle are joined.
bool is_loop(const World& world, std::size_t connector);

/// Whether a connector resists twist and has what holds it: clamps at both of its ends, or itself
/// where it is a closed loop that no clamp holds. Throws std::invalid_argument where it is clamped
/// elsewhere, too.
bool carries_twist(const World& world, std::size_t connector);

/// The frame of a hold that clamps, at `time`: its x axis is the direction that it holds.
struct ClampFrame {
  Quat frame = Quat::Identity();
  double spin = 0;                 // rad/s, about that direction
  double turn = 0, turn_rate = 0;  // rad and rad/s: what Hold::turn adds
};
ClampFrame clamp_frame(const World& world, const Hold& hold, double time);

/// How far the last clamp of a connector that carries twist is turned against the first at the
/// world's time, Hold::turn aside: rad, from -pi to pi. Of a closed loop its first link's frame is
/// both.
double end_turn(const World& world, std::size_t connector);

}  // namespace taut
