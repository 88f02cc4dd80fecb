// Plane chains from a fixed point, in the angles of pin joints.
#pragma once

#include <optional>
#include <vector>

#include "sim/motion/plane.h"
#include "sim/reference/sdfast/chain.h"
#include "sim/reference/sdfast/model.h"

namespace taut::sdfast {

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

}  // namespace taut::sdfast
