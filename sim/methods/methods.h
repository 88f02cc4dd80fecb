// The methods of this folder, which list.cpp lists.
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

/// Per evaluation, tensions T of all links at once such that each link's excess C (m) returns to
/// zero critically damped: C'' + (2/tau) C' + C/tau^2 = 0, tau the time constant. With the system's
/// second derivative C'' = c - A T (c without tensions, A = J M^-1 J^T) that is
///   A T = c + (2/tau) C' + C/tau^2.
/// Where A is singular (a straight connector between two fixed ends, say) the forces of least norm
/// that come closest are taken.
MethodInfo dynamic_constraints_method();

/// The particle system: a stiff spring with a damper for each link.
MethodInfo springs_method();

/// Per step everything moves freely; then passes over the links, in order, move their ends towards
/// the rest length, and velocities follow from positions. With compliance a (m/N) each pass adds
///   dl = -(C + a l / dt^2) / (w_a + w_b + a / dt^2)
/// to the link's multiplier l (kg m), C (m) its excess and w (1/kg) its ends' inverse masses along
/// it; at a rigid body w is 1/m + (r x n).I^-1 (r x n) (Mueller et al. 2020).
MethodInfo xpbd_method();

}  // namespace taut::methods
