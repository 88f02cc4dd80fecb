// Links at their full length between two holds.
#pragma once

#include <string>

#include "sim/components.h"

namespace taut::direct {

/// Where links of the part have no slack left between two places that are held, as is known
/// beforehand, and so have nowhere to go: says so. Empty where there is none.
std::string full_length(const World& world, const Component& part, double time);

}  // namespace taut::direct
