// The methods that need other libraries, which list.cpp lists.
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

/// A SimbodyModel of the world; its integrator's error is controlled by the accuracy.
MethodInfo multibody_method();

/// Equations of motion in joint coordinates, written as C by SD/FAST's generator when taut was
/// built, and its own integrator, Runge-Kutta-Merson with steps by error control. Follows one
/// chain, from a fixed or moving point or from nothing at all, with a free body at either end or
/// none: with pin joints where it hangs from a fixed point and stays in a plane, otherwise with
/// ball joints. Diverged says what it does not follow: loops, pins between the ends, several
/// connectors. `missing` where the generator was not installed.
MethodInfo sdfast_method();

}  // namespace taut::reference
