// Whether interventions can be, as far as that is known beforehand or when their time comes.
#pragma once

#include <string>

#include "sim/timeline.h"

namespace taut {

/// Why a pin at `along` (m) of the connector cannot be taken to where `to` is now: how far that is
/// from what holds the connector elsewhere, and what the connector allows; empty where it can.
std::string why_out_of_reach(const World& world, std::size_t connector, double along,
                             const Attachment& to);

/// A pin that what holds its neighbour along the connector has left behind.
struct Parted {
  std::uint64_t pin = 0;  // its number in the world
  std::string what;       // ends a sentence about it
};

/// The first pin that is, at `time` (s), farther from its neighbour than the links between them
/// reach, or nearer than they fold, where the motion of both is known and one of them moves.
std::optional<Parted> find_parted(const World& world, double time);

}  // namespace taut
