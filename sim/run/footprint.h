// The footprint of a simulation on a machine, known before it starts.
#pragma once

#include "sim/run/method.h"

namespace taut {

struct Footprint {
  double memory = 0;  // bytes, at most
  double step = 0;    // s of one processor that a step takes, roughly
};

/// Of `method`, with a full set of settings, on `world`, which is copied once.
Footprint footprint(const MethodInfo& method, const World& world, const Settings& settings);

}  // namespace taut
