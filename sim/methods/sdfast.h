// SD/FAST, the multibody package that the paper compares with.
#pragma once

#include "sim/method.h"

namespace taut {

/// Equations of motion in joint angles, written as C by SD/FAST's generator when taut was built,
/// and its own integrator, Runge-Kutta-Merson with steps by error control. Follows one chain that
/// hangs in a plane from a fixed point, with or without a point mass at its end; Diverged says so
/// of other worlds. `missing` where the generator was not installed.
MethodInfo sdfast_method();

}  // namespace taut
