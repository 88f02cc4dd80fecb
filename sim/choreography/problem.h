// The problem of a choreography: the waypoints, and the limits of the hand.
#pragma once

#include <limits>
#include <vector>

#include "sim/interventions/timeline.h"
#include "sim/motion/types.h"
#include "sim/world/world.h"

namespace taut::choreography {

/// A place that is to be passed.
struct Waypoint {
  double time = 0;               // s
  Vec3 position = Vec3::Zero();  // m
};

/// Limits of the hand's path: a hundredth beyond costs the fit as much as a waypoint
/// missed by 0.3 mm. HandPath tells what was kept.
struct HandLimits {
  Vec3 shoulder = Vec3::Zero();                                   // m
  double reach = std::numeric_limits<double>::infinity();         // m, from the shoulder
  double speed = std::numeric_limits<double>::infinity();         // m/s
  double acceleration = std::numeric_limits<double>::infinity();  // m/s^2
  /// m, between a line from the pivot to the chain's end, and the body's from where it hangs to the
  /// point; counts where there is a pivot.
  double clearance = 0;
};

/// The problem. The path that drives the other end of the body's connector rests from its last key
/// on; there the hand's path begins, and there it ends.
struct Choreography {
  World world;  // at its start
  Timeline timeline;
  std::size_t body = 0;             // for which why_not_flat() has no reason
  Vec3 point = Vec3::Zero();        // m, body frame, on the line that the body hangs by
  std::vector<Waypoint> waypoints;  // times rising
  double until = 0;                 // s, when hand and body rest again
  HandLimits limits;
  /// A held body points away from a place so far (m) behind the connector's end; infinite: it
  /// keeps its orientation.
  double pivot = std::numeric_limits<double>::infinity();
};

}  // namespace taut::choreography
