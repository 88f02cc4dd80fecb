// The highest frequencies of a world that hangs at rest: the bound of theory on explicit steps.
#pragma once

#include "sim/world/world.h"

namespace taut {

// Each connector hangs straight down from its first held particle, with a free body at its end as a
// point. All are zero where nothing hangs. Where connectors are joined they are bounds, since
// nobody knows what hangs on which link: as if all that moves hung on each.

/// The highest frequency (rad/s) at which the connectors of `world` swing sideways. For n equal
/// beads below a fixed point its square is the largest zero of the Laguerre polynomial L_n times
/// g/l; 2 sqrt(T/(m l)), T the tension at the top, bounds it.
double highest_swing_frequency(const World& world);

/// The highest frequency (rad/s) at which they stretch, each link a spring of `stiffness` (N/m);
/// 2 sqrt(stiffness/m) bounds it.
double highest_stretch_frequency(const World& world, double stiffness);

/// The largest T/(m l) (1/s^2) of any link: T its tension, m the lighter of the masses that it
/// joins, l its length.
double heaviest_link(const World& world);
/// The same of links that stretch, with the tensions of the present state.
double tightest_link(const World& world);
/// The largest S/(m l^2) (1/s^2) of any link of connectors that resist bending: S the sum of the
/// moments in all bends, each that of the weight at half of the length, or all that of half a turn.
double heaviest_bend(const World& world);
/// The largest T/l (N/m) of any link.
double strongest_pull(const World& world);

}  // namespace taut
