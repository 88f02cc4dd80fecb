// The particle system: a hard spring and damper per link.
#pragma once

#include "sim/method.h"
#include "sim/methods/stepped.h"

namespace taut {

MethodInfo springs_method();

/// The longest stable step (s) of an oscillator x'' + 2 z w x' + w^2 x = 0, as a multiple of 1/w;
/// zero where the integrator is never stable (explicit Euler without damping).
double stability_limit(Integrator integrator, double damping_ratio);

}  // namespace taut
