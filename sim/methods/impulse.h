// Impulse and reposition: the flexible connectors of "An Efficient Method for Simulating Flexible
// Connectors", sections IV.A to IV.C.
#pragma once

#include "sim/run/method.h"

namespace taut::methods {

/// Bodies and particles move freely. A span longer than its length whose ends separate gives them
/// the impulse of equation (5). Particles are repositioned where a neighbour is nearer or farther
/// than allowed, then where an end is farther than its share of the length, the ends last; their
/// velocities follow from their positions. Held particles divide a connector into spans, each
/// simulated by itself.
///
/// The paper's equation (5) holds for a fixed other end, lets a handle sink, and no rule clamps the
/// end body. Where `as_printed` is false both ends' terms stand in its denominator, the mass ratio
/// scales the rebound alone, and the impulse acts at the moment within the step at which the span
/// became taut: the ends have moved with their new velocities since, which leaves them within reach
/// and keeps momentum, angular momentum and, while a span stays taut, energy.
///
/// Beads inside of obstacles after their flight are placed on the surfaces. Where a span's pull
/// presses them on, they are its corners: held by friction they divide it, as pins do; else it
/// slides around them, and equation (5) is that of the whole way from end to end, with pulls that
/// differ by what friction takes (SpanPath). Where `as_printed`, corners always divide.
MethodInfo impulse_method();

}  // namespace taut::methods
