// Where a connector lets its places be taken.
#pragma once

#include "sim/interventions/outcome.h"
#include "sim/world/places.h"
#include "sim/world/world.h"

namespace taut {

/// Whether `along` (m) is on the connector.
bool on(const Connector& connector, double along);

/// Where a particle will be once it is drawn to what holds it, as far as that is known.
Vec3 goal(const World& world, const Attachment& to, double arrival);

/// Where a place is to go, and whether it is drawn there.
struct Move {
  Vec3 now, target;
  bool drawn;
};

/// Whether what holds the connector elsewhere, where it is and where it is being drawn to, lets the
/// place go to the target or, drawn, straight there; then free bodies follow. One pass over the
/// links, from the place to the first hold on either side that does not give way: the links beyond
/// it begin there.
Outcome feasible(const World& world, const Connector& connector, const Place& place,
                 const Move& move);

/// How far the span around a particle that was added can go once the links beside it are one.
enum class Joined { straightens, needs_a_body, bent };

/// A span as it will be, once some of its particles have gone.
struct JoinedSpan {
  std::size_t first = 0, last = 0;  // particles, as they are now
  double length = 0, longest = 0;   // m, of it and its longest link
};

/// Holds on either side may be nearer than the links between them fold; then a free body among them
/// must give way.
Joined join(const World& world, const Connector& connector, const JoinedSpan& span);

}  // namespace taut
