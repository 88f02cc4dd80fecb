// A world as SD/FAST's models see it: one chain from its base to its tip, in the angles of pin
// joints (in a plane, from a fixed point) or in the coordinates of ball joints (in space).
#pragma once

#include <optional>
#include <vector>

#include "sim/motion/plane.h"
#include "sim/reference/sdfast/model.h"
#include "sim/world/world.h"

namespace taut::sdfast {

/// The only connector of a world, counted from what holds it where its motion is known beforehand,
/// otherwise from its first particle.
struct Chain {
  std::optional<Attachment> held;       // of the base, where its motion is known beforehand
  std::optional<Attachment> base, tip;  // on free bodies
  bool reversed = false;
  std::size_t links = 0;

  std::size_t particle(std::size_t i) const { return reversed ? links - i : i; }
  std::size_t link(std::size_t k) const { return reversed ? links - 1 - k : k; }
};

/// The chain of `world`. Throws std::invalid_argument that says what no model follows.
Chain find_chain(const World& world);

// Plane chains from a fixed point, in the angles of pin joints.

/// The plane in which the chain moves and its weight pulls, or none; none, too, where it does not
/// hang from a fixed point or holds a body.
std::optional<Plane> plane_of(const World& world, const Chain& chain);

/// Gives the model the chain's masses and lengths. In its reference shape the chain hangs down, so
/// that joints lie above particles.
void set_up_pins(const Model& model, const World& world, const Chain& chain, const Plane& plane);
/// Reads the state of a model from `world`, and writes it there.
void load_pins(const World& world, const Chain& chain, const Plane& plane,
               std::vector<double>& state);
void store_pins(const std::vector<double>& state, const Chain& chain, const Plane& plane,
                World& world);

// Chains in space, in the coordinates of ball joints.
//
// A link is a massless line with a particle at its far end. A ball joint lets it turn about itself,
// which moves no mass: the line gets a moment of inertia about itself, and that alone. Joints at
// its two ends put no torque about it, so that its spin about itself stays what it was, zero, and
// the moment never acts: the motion is exactly that of the particles. Where the base or the tip of
// a model is a particle, it gets moments about all axes, which nothing turns either.

/// Gives the model the masses and lengths of the chain and its bodies.
void set_up_balls(const Model& model, const World& world, const Chain& chain);
/// Reads the state of a model from `world`, whose links must not be stretching.
void load_balls(const World& world, const Chain& chain, std::vector<double>& state);
/// Writes the state at `time` to `world`, whose held particles it leaves alone, and makes the
/// quaternions of the state units again.
void store_balls(std::vector<double>& state, const Chain& chain, double time, World& world);
/// Pushes every body of a held chain's model against the base's `acceleration` (m/s^2), as if its
/// frame, which does not turn, were at rest.
void drag_balls(const Model& model, const World& world, const Chain& chain,
                const Vec3& acceleration);

}  // namespace taut::sdfast
