// The particle system: a hard spring and damper per link.
#pragma once

#include "sim/run/method.h"

namespace taut::methods {

MethodInfo springs_method();

}  // namespace taut::methods
