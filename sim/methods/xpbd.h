// Extended position-based dynamics with small steps (Macklin et al. 2016 and 2019).
#pragma once

#include "sim/run/method.h"

namespace taut::methods {

/// Per step everything moves freely; then passes over the links, in order, move their ends towards
/// the rest length, and velocities follow from positions. With compliance a (m/N) each pass adds
///   dl = -(C + a l / dt^2) / (w_a + w_b + a / dt^2)
/// to the link's multiplier l (kg m), C (m) its excess and w (1/kg) its ends' inverse masses along
/// it; at a rigid body w is 1/m + (r x n).I^-1 (r x n) (Mueller et al. 2020).
MethodInfo xpbd_method();

}  // namespace taut::methods
