// The limits of an arm.
#pragma once

#include "scenes/character/performance.h"

namespace taut::scenes {

/// How much farther (m) the hand of a performance that make_performance() made is asked to be at
/// `time` than a body that stands can bring it; 0: within its reach.
double beyond_reach(const Performance& performance, double time);

}  // namespace taut::scenes
