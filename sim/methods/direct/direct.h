// The direct method: all links of a connector at once, exactly, in linear time.
#pragma once

#include "sim/run/method.h"

namespace taut::direct {

/// The row of the list of methods.
MethodInfo direct_method();

}  // namespace taut::direct
