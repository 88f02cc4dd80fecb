// The direct method: all links of a connector at once, exactly, in linear time.
#pragma once

#include "sim/method.h"

namespace taut {

/// The row of the list of methods.
MethodInfo direct_method();

}  // namespace taut
