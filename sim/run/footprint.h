// The memory of a simulation, known before it starts.
#pragma once

#include "sim/run/method.h"

namespace taut {

/// Bytes, at most, of `method` with a full set of settings on `world`, which is copied once.
double memory_of(const MethodInfo& method, const World& world, const Settings& settings);

}  // namespace taut
