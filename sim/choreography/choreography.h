// Choreography: finds the path of a hand that leads a body on a taut chain through given points at
// given times.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "sim/interventions/timeline.h"
#include "sim/motion/path.h"
#include "sim/world/world.h"

namespace taut::choreography {

/// A place that is to be passed.
struct Waypoint {
  double time = 0;               // s
  Vec3 position = Vec3::Zero();  // m
};

/// Limits on the hand's path: a hundredth beyond costs the fit as much as a waypoint missed by 0.3
/// mm. HandPath tells the values reached.
struct HandLimits {
  Vec3 shoulder = Vec3::Zero();                                   // m
  double reach = std::numeric_limits<double>::infinity();         // m, from the shoulder
  double speed = std::numeric_limits<double>::infinity();         // m/s
  double acceleration = std::numeric_limits<double>::infinity();  // m/s^2
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

/// The path found, and how near it comes. All values of the hand are the path's, sampled four times
/// between its keys.
struct HandPath {
  std::vector<PathKey> keys;  // the keys that the path had, and those found
  std::vector<double> miss;   // m, of each waypoint, by the exact simulation
  double reach = 0;           // m, the farthest from the shoulder
  double speed = 0;           // m/s
  double acceleration = 0;    // m/s^2
  double tension = 0;         // N, the least of the body's link
};

/// The world with another path in the place of the one that drives the body's connector.
World with_hand_path(const World& world, std::size_t body, const std::vector<PathKey>& keys);

/// Distances (m) of the body's point from the waypoints, by `direct` at a tolerance of `tolerance`
/// (m). Throws Diverged.
std::vector<double> misses(const Choreography& problem, const std::vector<PathKey>& keys,
                           double tolerance);

/// The smoothest path of the hand that leads the body's point through the waypoints, the worst of
/// them missed by at most `within` (m) where that can be had; else the best that was found. First
/// by the flat chain, then round by round aimed beside the points by what the simulation missed;
/// `watch` hears the worst miss of each round. The same bits on every run.
HandPath choreograph(const Choreography& problem, double within,
                     const std::function<void(double miss)>& watch = {});

}  // namespace taut::choreography
