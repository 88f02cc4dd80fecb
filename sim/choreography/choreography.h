// Choreography: finds the path of a hand that leads a body on a taut chain through given points at
// given times.
#pragma once

#include <functional>
#include <vector>

#include "sim/choreography/flat_fit.h"
#include "sim/motion/path.h"
#include "sim/world/world.h"

namespace taut::choreography {

/// The most that a hand does, sampled four times between the path's keys.
struct HandMotion {
  double reach = 0;         // m, the farthest from the shoulder
  double speed = 0;         // m/s
  double acceleration = 0;  // m/s^2
};

/// The path found, and how near it comes.
struct HandPath {
  std::vector<PathKey> keys;  // the keys that the path had, and those found
  std::vector<double> miss;   // m, of each waypoint, by the exact simulation
  HandMotion hand;            // from the first key found on
  double tension = 0;         // N, the least of the body's link
};

inline constexpr int kMostRounds = 12;  // of choreograph()

/// The world with another path in the place of the one that drives the body's connector.
World with_hand_path(const World& world, std::size_t body, const std::vector<PathKey>& keys);

/// Distances (m) of the body's point from the waypoints in a world whose hand has its path, such as
/// with_hand_path() makes, by `direct` at a hundredth of `within` (m). Throws Diverged.
std::vector<double> misses(const Choreography& problem, const World& world, double within);

/// The motion of the hand by those keys, from where the problem's own end until `until`.
HandMotion motion_of_hand(const Choreography& problem, const std::vector<PathKey>& keys);

/// How many Gaussians the curve is that choreograph() fits: it takes memory by their square, and
/// time by their cube.
std::size_t gaussians(const Choreography& problem);

/// The smoothest path of the hand that leads the body's point through the waypoints, the worst of
/// them missed by at most `within` (m) where that can be had; else the best that was found. First
/// by the flat chain, then round by round aimed beside the points by what the simulation missed;
/// `watch` hears the worst miss of each round, and `tick` is called now and then: what they throw
/// ends it. The same bits on every run.
HandPath choreograph(const Choreography& problem, double within,
                     const std::function<void(double miss)>& watch = {},
                     const std::function<void()>& tick = {});

}  // namespace taut::choreography
