// The particle system: a hard spring and damper per link.
#pragma once

#include "sim/run/method.h"

namespace taut {

MethodInfo springs_method();

}  // namespace taut
