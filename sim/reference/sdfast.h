// SD/FAST, the multibody package that the paper compares with.
#pragma once

#include "sim/run/method.h"

namespace taut::reference {

/// Equations of motion in joint coordinates, written as C by SD/FAST's generator when taut was
/// built, and its own integrator, Runge-Kutta-Merson with steps by error control. Follows one
/// chain, from a fixed or moving point or from nothing at all, with a free body at either end or
/// none: with pin joints where it hangs from a fixed point and stays in a plane, otherwise with
/// ball joints. Diverged says what it does not follow: loops, pins between the ends, several
/// connectors. `missing` where the generator was not installed.
MethodInfo sdfast_method();

}  // namespace taut::reference
