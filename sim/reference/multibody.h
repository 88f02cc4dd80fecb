// A general multibody package with joint coordinates: Simbody, the open successor of SD/FAST.
#pragma once

#include "sim/run/method.h"

namespace taut::reference {

/// A SimbodyModel of the world; its integrator's error is controlled by the accuracy.
MethodInfo multibody_method();

}  // namespace taut::reference
