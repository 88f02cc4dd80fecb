// The first solver of the truth: constraint multipliers and projection under an integrator of high
// order that controls its error.
#pragma once

#include "sim/run/method.h"

namespace taut::reference {

/// The method `truth`. Accelerations from the tensions that keep every link's length (index-1
/// equations of motion), integrated by Runge-Kutta-Fehlberg 7(8) of Boost.odeint; after every
/// accepted step positions and velocities are projected onto the links along M^-1 J^T, so that
/// lengths hold to rounding. Steps end at the keys of paths, where those are only C2.
///
/// Among obstacles it goes from event to event (EventDriven).
///
/// Throws Diverged where the links' lengths cannot be kept (ends pulled apart beyond the length).
MethodInfo truth_method();

}  // namespace taut::reference
