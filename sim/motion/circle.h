// A point that goes round a circle, its angular speed reached smoothly from rest.
#pragma once

#include "sim/motion/types.h"

namespace taut {

/// From rest at `start` at time 0 about `centre`, right-handed about `axis`: the angular speed is
/// 2 pi frequency s(t/ramp) with the smoothstep s(u) = 3u^2 - 2u^3, and constant after the ramp.
struct Circle {
  Vec3 centre = Vec3::Zero();  // m
  Vec3 start = Vec3::UnitX();  // m; start - centre is at right angles to the axis
  Vec3 axis = Vec3::UnitZ();   // unit vector
  double frequency = 1;        // turns per second, above 0
  double ramp = 1;             // s, above 0
};

/// The motion at `time` (s), in closed form; the frame keeps the world's axes.
FrameMotion motion(const Circle& circle, double time);

}  // namespace taut
