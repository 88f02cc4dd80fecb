#include "sim/choreography/choreography.h"

#include <algorithm>

#include "sim/choreography/flat_fit.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"

namespace taut::choreography {

World with_hand_path(const World& world, std::size_t body, const std::vector<PathKey>& keys) {
  const std::shared_ptr<const Path> old = hand_path(world, body);
  const auto found = std::make_shared<const Path>(keys);
  return with_change(world, [&](World& other) {
    for (Body& each : other.bodies) {
      if (each.path == old) each.path = found;
    }
    for (Connector& connector : other.connectors) {
      for (Hold& hold : connector.holds) {
        if (hold.to.path == old) hold.to.path = found;
      }
    }
  });
}

namespace {

constexpr double kCertain = 0.01;  // of what is asked: the tolerance of the simulation

/// Where the body's point is minus where it should be, at each waypoint.
std::vector<Vec3> deviations(const Choreography& problem, const World& world, double within) {
  Simulation simulation(world, make_method("direct", {{"tolerance", kCertain * within}}),
                        problem.timeline);
  std::vector<Vec3> off;
  for (const Waypoint& waypoint : problem.waypoints) {
    simulation.advance_to(waypoint.time);
    const Pose frame = simulation.state().bodies[problem.body];
    off.push_back(frame.to_world(problem.point) - waypoint.position);
  }
  return off;
}

std::vector<double> lengths(const std::vector<Vec3>& vectors) {
  std::vector<double> list;
  for (const Vec3& vector : vectors) list.push_back(vector.norm());
  return list;
}

}  // namespace

HandMotion motion_of_hand(const Choreography& problem, const std::vector<PathKey>& keys) {
  const Path path(keys);
  const double from = hand_path(problem.world, problem.body)->keys().back().time;
  constexpr int kBetween = 4;
  HandMotion most;
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const double begin = keys[k - 1].time, end = keys[k].time;
    if (begin < from || end > problem.until) continue;
    for (int i = 0; i <= kBetween; ++i) {
      const FrameMotion hand = path.at(begin + (end - begin) * i / kBetween);
      most.reach = std::max(most.reach, (hand.position - problem.limits.shoulder).norm());
      most.speed = std::max(most.speed, hand.velocity.norm());
      most.acceleration = std::max(most.acceleration, hand.acceleration.norm());
    }
  }
  return most;
}

std::vector<double> misses(const Choreography& problem, const World& world, double within) {
  return lengths(deviations(problem, world, within));
}

std::size_t gaussians(const Choreography& problem) {
  const double from = hand_path(problem.world, problem.body)->keys().back().time;
  return static_cast<std::size_t>(FlatFit::gaussians(problem, from));
}

HandPath choreograph(const Choreography& problem, double within,
                     const std::function<void(double)>& watch, const std::function<void()>& tick) {
  if (problem.world.topology == 0) {
    Choreography finished = problem;
    finish(finished.world);
    return choreograph(finished, within, watch, tick);
  }
  const std::vector<PathKey> before = hand_path(problem.world, problem.body)->keys();
  const double from = before.back().time;
  FlatFit fit(problem, from);
  std::vector<Vec3> aims;
  for (const Waypoint& waypoint : problem.waypoints) aims.push_back(waypoint.position);

  HandPath best;
  double best_miss = std::numeric_limits<double>::infinity();
  constexpr double kWorthwhile = 0.9;  // of the miss before
  constexpr double kAstray = 0.2;      // m: what aims beside the points do not mend
  for (int round = 0; round < kMostRounds && best_miss > within; ++round) {
    fit.solve(aims, tick);
    HandPath found{before, {}, {}};
    found.keys.back().ease = true;
    for (const PathKey& key : fit.keys()) found.keys.push_back(key);
    const std::vector<Vec3> off =
        deviations(problem, with_hand_path(problem.world, problem.body, found.keys), within);
    found.miss = lengths(off);
    const double miss = *std::ranges::max_element(found.miss);
    if (watch) watch(miss);
    const bool improves = miss < kWorthwhile * best_miss;
    if (miss < best_miss) {
      found.tension = fit.least_tension();
      found.hand = motion_of_hand(problem, found.keys);
      best = std::move(found);
      best_miss = miss;
    }
    if (!improves || miss > kAstray) break;
    for (std::size_t k = 0; k < aims.size(); ++k) aims[k] -= off[k];
  }
  return best;
}

}  // namespace taut::choreography
