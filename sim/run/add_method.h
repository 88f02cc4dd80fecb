// Methods that join the list from outside of it.
#pragma once

#include "sim/run/method.h"

namespace taut {

/// Adds a method to all_methods(), for every part of the program: before the one called `before`,
/// or at the end. Call before anything else has looked at the list; `method` names storage that
/// outlives the program.
void add_method(MethodInfo method, std::string_view before = {});

}  // namespace taut
