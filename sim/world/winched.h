// Winches in a world: what they may be at, and the lengths and masses that they give.
#pragma once

#include <memory>
#include <string>

#include "sim/world/world.h"

namespace taut {

/// Puts winches at the ends of a connector whose links are equal, as its holds are: at the start,
/// when it is as long as its `rest`. `first` and `last` are Winch::paths, and either may be null. A
/// link at a free body keeps its length, so that the body keeps its mass. Throws
/// std::invalid_argument where there is no other link.
void add_winches(const World& world, Connector& connector, std::shared_ptr<const Path> first,
                 std::shared_ptr<const Path> last);

/// What is wrong with a world's winches, or empty: they are at ends whose motion is known
/// beforehand, of rigid links that no pin holds and no joint, in worlds without contact, strings
/// and massless spans.
std::string winch_flaw(const World& world);

/// Gives a connector that has winches the rest lengths and masses of `time` (s).
void set_lengths(Connector& connector, double time);

}  // namespace taut
