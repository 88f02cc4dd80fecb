// A world that is consistent: bodies weigh what they hold, and what is held is in its place.
#pragma once

#include <string>

#include "sim/world/held.h"
#include "sim/world/joined.h"
#include "sim/world/state.h"
#include "sim/world/structure.h"

namespace taut {

/// Joins the masses of particles held by free bodies to those bodies, sets every held particle and
/// driven body to its place at `world.time`, takes connectors for untwisted, and numbers the
/// topology. Call once, after building a world. Throws std::invalid_argument where joint_flaw(),
/// pair_flaw() or winch_flaw() finds one, or carries_twist() throws.
void finish(World& world);

/// Makes a finished world consistent again after changes by hand to connectors, holds, joints,
/// obstacles or a body's `bare` mass, or after more bodies: free bodies weigh what they hold now,
/// everything held is in its place, and the topology is numbered. Does nothing where nothing that
/// structure() tells has changed. Throws like finish(). Nobody needs to call it: a Simulation does
/// before it advances, where its world() was asked for, and with_change() after the change.
void refresh(World& world);

/// The world after a change by hand, `change(world)`, made consistent: finished, or as by
/// refresh() where it has been finished already. Throws like finish().
template <class Change>
World with_change(World world, Change&& change) {
  change(world);
  if (world.topology == 0) {
    finish(world);
  } else {
    refresh(world);
  }
  return world;
}

/// The flaw of World::pairs, World::bead_pairs and World::connector_pairs, or empty: each is of
/// free bodies that have capsules, and stands there once.
std::string pair_flaw(const World& world);

/// Weighs all free bodies again, each with the particles that it holds.
void reweigh(World& world);

/// Sets the time, and with it driven bodies and the particles held by anything, free bodies
/// included, and those that are joined, to their places and velocities.
void place_held(World& world, double time);

/// The same of all but the particles held by free bodies, and of these alone.
void place_prescribed(World& world, double time);
void place_carried(World& world);

/// Sets the time, driven bodies to their places and velocities, and the lengths and masses of
/// connectors that have winches.
void place_driven(World& world, double time);

}  // namespace taut
