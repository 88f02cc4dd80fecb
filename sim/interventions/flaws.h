// Whether interventions can be, as far as that is known beforehand or when their time comes.
#pragma once

#include <string>

#include "sim/interventions/timeline.h"

namespace taut {

/// Why a pin at `along` (m) of the connector cannot be taken to where `to` is now: how far that is
/// from what holds the connector elsewhere, and what the connector allows; empty where it can.
std::string why_out_of_reach(const World& world, std::size_t connector, double along,
                             const Attachment& to);

/// Why nothing may let go of the particle of a connector where it is: as a bead that is free it
/// would be inside of an obstacle, where no bead can be; empty where it may.
std::string why_inside(const World& world, std::size_t connector, std::size_t particle);

}  // namespace taut
