// Small scenes of any two features of sim/features, and of a third at times, of sizes drawn from a
// seed.
#pragma once

#include <string>

namespace taut::drawn {

/// A scene of half a second; seeds go round all pairs. Its method is drawn, too, and takes steps of
/// one length where it can, once in four. The reader refuses what the method does not follow.
std::string pair_text(unsigned seed);

/// How many pairs there are.
unsigned pair_count();

}  // namespace taut::drawn
