// Methods that a program brings along, beside those of the list.
#pragma once

#include "sim/method.h"

namespace taut {

/// Adds a method at the end of methods(), for every part of the program. Call before anything else
/// has looked at the list; `method` names storage that outlives the program.
void add_method(MethodInfo method);

}  // namespace taut
