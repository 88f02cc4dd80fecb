// The whole physical state: bodies, connectors, gravity and the time; and what stands in their way.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/motion/path.h"
#include "sim/motion/types.h"
#include "sim/winch/pulley.h"
#include "sim/world/body.h"
#include "sim/world/connector.h"
#include "sim/world/joint.h"
#include "sim/world/obstacle.h"

namespace taut {

/// The air that connectors with drag coefficients move through; the same everywhere.
struct Air {
  double density = 0;        // kg/m^3; zero: none
  Vec3 wind = Vec3::Zero();  // m/s
  /// Where it is in m, the wind is in m/s, beside `wind`. None: the wind is the same at all times.
  std::shared_ptr<const Path> gusts = nullptr;

  Vec3 wind_at(double time) const { return gusts ? Vec3(wind + gusts->at(time).position) : wind; }
};

/// A value: copying a world copies its state (paths are shared, they never change).
struct World {
  double time = 0;                   // s
  Vec3 gravity = Vec3(0, -9.81, 0);  // m/s^2
  Air air;
  std::vector<Body> bodies;
  std::vector<Connector> connectors;
  std::vector<Joint> joints;        // what joins connectors to each other and to themselves
  std::vector<Pulley> pulleys;      // where rope passes from one connector into another
  std::vector<Obstacle> obstacles;  // what beads of connectors and free bodies touch
  std::vector<BodyPair> pairs;      // of free bodies that touch each other
  std::uint64_t topology = 0;       // another one whenever what structure() tells changes
  std::uint64_t pins = 0;           // how many there ever were
};

/// Joins the masses of particles held by free bodies to those bodies, sets every held particle and
/// driven body to its place at `world.time`, takes connectors for untwisted, and numbers the
/// topology. Call once, after building a world. Throws std::invalid_argument where joint_flaw(),
/// pair_flaw() or winch_flaw() finds one, or carries_twist() throws.
void finish(World& world);

/// Makes a finished world consistent again after changes by hand to connectors, holds, joints,
/// obstacles or a body's `bare` mass, or after more bodies: free bodies weigh what they hold now,
/// everything held is in its place, and the topology is numbered. Does nothing where nothing that
/// structure() tells has changed. A Simulation calls it. Throws like finish().
void refresh(World& world);

/// The flaw of World::pairs, or empty: each is of two free bodies that have capsules, and stands
/// there once.
std::string pair_flaw(const World& world);

/// Whether some connector stretches, resists bending or meets the air (Connector::sections).
bool has_materials(const World& world);

/// Whether anything touches: there are obstacles, or bodies that touch each other.
bool has_contact(const World& world);

/// Whether some connector has a winch or passes a pulley (Connector::winch).
bool has_winches(const World& world);

/// Whether some connector's links are strings (Connector::pulls).
bool has_strings(const World& world);

/// Whether some free body touches obstacles (Body::capsule), and there are some, or another body.
bool has_touching_bodies(const World& world);

/// A hash of all that moves in no step: connectors with their rest lengths and masses, what holds
/// them, joins them and turns beside them, bodies with their mass properties, paths, obstacles,
/// pairs. Methods build on it, so World::topology is this number, which refresh() takes anew.
std::uint64_t structure(const World& world);

/// The terms of a body, a connector and a joint in structure(), a sum modulo 2^64: so that the
/// topology follows a change of a few of them without a look at the others.
std::uint64_t structure_of_body(const World& world, std::size_t body);
std::uint64_t structure_of_connector(const World& world, std::size_t connector);
std::uint64_t structure_of_joint(const World& world, std::size_t joint);

/// Weighs all free bodies again, each with the particles that it holds.
void reweigh(World& world);

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

/// Sets the time, and with it driven bodies and the particles held by anything, free bodies
/// included, and those that are joined, to their places and velocities.
void place_held(World& world, double time);

/// The same of all but the particles held by free bodies, and of these alone.
void place_prescribed(World& world, double time);
void place_carried(World& world);

/// Sets the time, driven bodies to their places and velocities, and the lengths and masses of
/// connectors that have winches.
void place_driven(World& world, double time);
/// Sets a particle that is held, but not by a free body, to its place and velocity at the world's
/// time, once driven bodies are at theirs.
void place_hold(const World& world, Connector& connector, const Hold& hold);

}  // namespace taut
