// Winches in a world: their places, and the lengths and masses that they give.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "sim/world/state.h"

namespace taut {

/// Puts winches at the ends of a connector whose links are equal, as its holds are: at the start,
/// when it is as long as its `rest`. `first` and `last` are Winch::paths, and either may be null. A
/// link at a free body keeps its length, so that the body keeps its mass, unless the connector has
/// none. `density` (kg/m) is of what is paid out; none: that of equal particles. Throws
/// std::invalid_argument where there is no other link.
void add_winches(const World& world, Connector& connector, std::shared_ptr<const Path> first,
                 std::shared_ptr<const Path> last, std::optional<double> density = {});

/// Lets rope pass from the last end of the connector `from` into the first end of `to`, both held
/// at one place; `inertia` as Pulley::inertia. Connectors without a winch, of equal particles, get
/// one that pays nothing out, and are weighed by their links. winch_flaw() tells what is wrong.
void add_pulley(World& world, std::string name, std::size_t from, std::size_t to, double inertia);

/// The length paid out at a connector's first (0) or last (1) end at `time` (s), by its winch and,
/// as far as the world is now, by its pulley, whose acceleration is left zero.
PaidOut paid_out(const World& world, std::size_t connector, std::size_t end, double time);

/// The flaw of a world's winches and pulleys, or empty: winches are at ends whose motion is known
/// beforehand, pulleys at one place of two connectors of one density; both of rigid links that no
/// pin holds and no joint.
std::string winch_flaw(const World& world);

/// Gives all connectors that have winches the rest lengths and masses of `time` (s) and of what has
/// passed the pulleys.
void set_lengths(World& world, double time);

}  // namespace taut
