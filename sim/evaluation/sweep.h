// The settings of a method that sweeps go through.
#pragma once

#include <vector>

#include "sim/run/method_choice.h"

namespace taut::study {

/// Every combination of the values that the method offers to sweeps, the last setting fastest.
/// `thin`: of each number only the ends and the middle.
std::vector<MethodChoice> sweep(const MethodInfo& method, bool thin);

}  // namespace taut::study
