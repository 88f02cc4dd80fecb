// Chains in space, in the coordinates of ball joints.
//
// A link is a massless line with a particle at its far end. A ball joint lets it turn about itself,
// which moves no mass: the line gets a moment of inertia about itself, and that alone. Joints at
// its two ends put no torque about it, so that its spin about itself stays what it was, zero, and
// the moment never acts: the motion is exactly that of the particles. Where the base or the tip of
// a model is a particle, it gets moments about all axes, which nothing turns either.
#pragma once

#include <vector>

#include "sim/reference/sdfast/chain.h"
#include "sim/reference/sdfast/model.h"

namespace taut::sdfast {

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
