// The holds of particles: how they move, and place particles.
#pragma once

#include "sim/world/state.h"

namespace taut {

/// The motion of a hold at `time` for fixed points, paths and driven bodies; for a free body the
/// present state, with the acceleration left zero.
PointMotion hold_motion(const World& world, const Attachment& to, double time);

/// True where the hold's motion is known beforehand: fixed, path, or driven body.
bool is_prescribed(const World& world, const Attachment& to);

/// The direction in which a hold clamps its connector at `time` (unit vector, world axes) and its
/// rate (1/s); zero where it is hinged.
struct ClampMotion {
  Vec3 direction = Vec3::Zero(), rate = Vec3::Zero();
};
ClampMotion clamp_motion(const World& world, const Hold& hold, double time);

/// Sets a particle that is held, but not by a free body, to its place and velocity at the world's
/// time, once driven bodies are at theirs.
void place_hold(const World& world, Connector& connector, const Hold& hold);

}  // namespace taut
