// The whole physical state: bodies, connectors, gravity and the time.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/body.h"
#include "sim/connector.h"
#include "sim/types.h"

namespace taut {

/// A value: copying a world copies its state (paths are shared, they never change).
struct World {
  double time = 0;                   // s
  Vec3 gravity = Vec3(0, -9.81, 0);  // m/s^2
  std::vector<Body> bodies;
  std::vector<Connector> connectors;
  std::uint64_t topology = 0;  // rises whenever a hold, link or connector comes or goes
};

/// Joins the masses of particles held by free bodies to those bodies, and sets every held particle
/// and driven body to its place at `world.time`. Call once, after building a world.
void finish(World& world);

/// The motion of a hold at `time` for fixed points, paths and driven bodies; for a free body the
/// present state, with the acceleration left zero.
PointMotion hold_motion(const World& world, const Attachment& to, double time);

/// True where the hold's motion is known beforehand: fixed, path, or driven body.
bool is_prescribed(const World& world, const Attachment& to);

/// Sets the time, and with it driven bodies and the particles held by anything, free bodies
/// included, to their places and velocities.
void place_held(World& world, double time);

}  // namespace taut
