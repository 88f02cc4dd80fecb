#include "sim/choreography/choreography.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/reader/reader.h"
#include "sim/choreography/flat_fit.h"

namespace taut::scenes {
namespace {

constexpr double kWithin = 0.002;  // m

/// A vector of the curve at that share of its time.
Vec3 on_the_way(const Value& curve, std::string_view key, double share) {
  const Vec3 from = curve.find(key)->vec3();
  const Value* to = curve.find("to");
  return to ? Vec3(from + share * (vec3_or(*to, key, from) - from)) : from;
}

void add_figure(const Document& document, const Value& curve,
                std::vector<choreography::Waypoint>& waypoints) {
  const double from = curve.find("from")->number, until = curve.find("until")->number;
  if (!(until > from)) {
    document.mismatch(*curve.find("until"), fmt::format("a time after {} s, when it begins", from));
  }
  const bool is_circle = curve.find("figure")->text == "circle";
  const double laps = curve.find("laps")->number;
  const int points = static_cast<int>(laps) * (is_circle ? 6 : 8);
  for (int k = 0; k <= points; ++k) {
    const double share = double(k) / points, angle = 2 * std::numbers::pi * laps * share;
    const double upward = is_circle ? -std::cos(angle) : std::sin(2 * angle);
    waypoints.push_back(
        {from + (until - from) * share, on_the_way(curve, "centre", share) +
                                            std::sin(angle) * on_the_way(curve, "across", share) +
                                            upward * on_the_way(curve, "up", share)});
  }
}

/// Those of the waypoints and of the curves, in the order of time. Where curves follow each other,
/// the end of one is the beginning of the next.
std::vector<choreography::Waypoint> read_waypoints(const Document& document, const Value& table) {
  std::vector<choreography::Waypoint> all;
  if (const Value* list = table.find("waypoints")) {
    for (const Value& entry : list->children) {
      all.push_back({entry.find("t")->number, entry.find("position")->vec3()});
    }
  }
  if (const Value* list = table.find("curves")) {
    for (const Value& curve : list->children) add_figure(document, curve, all);
  }
  if (all.empty()) document.fail_at_key(table, "has neither waypoints nor curves");
  std::ranges::stable_sort(all, {}, &choreography::Waypoint::time);
  constexpr double kOneTime = 1e-6;  // s, and m: the rounding of numbers that people type
  std::vector<choreography::Waypoint> apart;
  for (const choreography::Waypoint& each : all) {
    if (apart.empty() || each.time - apart.back().time > kOneTime) {
      apart.push_back(each);
    } else if (!((each.position - apart.back().position).norm() <= kOneTime)) {
      document.fail_at_key(table, fmt::format("is to be in two places at {} s", each.time));
    }
  }
  return apart;
}

choreography::HandLimits read_limits(const Value& table) {
  choreography::HandLimits limits;
  limits.shoulder = table.find("shoulder")->vec3();
  limits.reach = number_or(table, "reach", limits.reach);
  limits.speed = number_or(table, "speed", limits.speed);
  limits.acceleration = number_or(table, "acceleration", limits.acceleration);
  limits.clearance = number_or(table, "clearance", limits.clearance);
  return limits;
}

/// The path's keys before the first waypoint; the hand rests from the last of them on.
std::vector<PathKey> keys_before(const Document& document, const Value& table,
                                 const Motions& motions,
                                 const choreography::Choreography& problem) {
  const Value& name = *table.find("path");
  const Value* list = motions.path_value(name).find("keys");
  if (!list) document.mismatch(name, "a path of keys");
  double last = -std::numeric_limits<double>::infinity();
  const double first = problem.waypoints.front().time;
  for (const Value& key : list->children) {
    const double time = key.find("t")->number + number_or(key, "hold", 0);
    if (time < first) last = time;
    if (time >= first && time < problem.until) {
      document.fail(
          key, fmt::format("stands among the choreography, which ends at {} s", problem.until));
    }
  }
  std::vector<PathKey> keys = motions.path(name)->keys();
  std::erase_if(keys, [&](const PathKey& key) { return key.time > last; });
  if (keys.empty()) {
    document.fail_at_key(table, fmt::format("begins at {} s, before the path's first key", first));
  }
  return keys;
}

/// What the body touches counts where the whole scene is simulated. While the path is sought, what
/// a character carries along is not yet where the hand will take it.
World touching_nothing(const World& world) {
  return with_change(world, [](World& other) {
    other.obstacles.clear();
    other.pairs.clear();
    other.bead_pairs.clear();
    for (Body& body : other.bodies) body.capsule = {};
    for (Connector& connector : other.connectors) connector.links_touch = false;
  });
}

/// The point has to move with the line that the body hangs by.
void check_point(const Document& document, const Value& table,
                 const choreography::Choreography& problem) {
  const Vec3 from = choreography::hanging_hold(problem.world, problem.body).to.point;
  const Vec3 along = (problem.world.bodies[problem.body].bare.centre - from).normalized();
  const Vec3 to = problem.point - from;
  if (along.cross(to).norm() > kRounding * (1 + to.norm())) {
    const Value* point = table.find("point");
    document.mismatch(point ? *point : *table.find("body"),
                      "a point on the line through where the body hangs and its centre of mass");
  }
}

}  // namespace

Choreographed read_choreography(const Document& document, const Value& table,
                                const Motions& motions, const Scene& scene) {
  Choreographed made;
  choreography::Choreography& problem = made.problem;
  problem.world = scene.world;
  problem.timeline = scene.timeline;
  const Value& body = *table.find("body");
  problem.body = motions.body(body);
  const std::string reason = choreography::why_not_flat(scene.world, scene.timeline, problem.body);
  if (!reason.empty()) document.fail(body, fmt::format("cannot be led: it is {}", reason));
  if (choreography::hand_path(scene.world, problem.body)->fingerprint() !=
      motions.path(*table.find("path"))->fingerprint()) {
    document.mismatch(*table.find("path"), "the path that drives the end that the body hangs from");
  }
  problem.point = vec3_or(table, "point", Vec3::Zero());
  check_point(document, table, problem);
  problem.waypoints = read_waypoints(document, table);
  problem.until = table.find("until")->number;
  if (!(problem.until > problem.waypoints.back().time)) {
    document.mismatch(
        *table.find("until"),
        fmt::format("a time after {} s, that of the last waypoint", problem.waypoints.back().time));
  }
  problem.world = touching_nothing(choreography::with_hand_path(
      scene.world, problem.body, keys_before(document, table, motions, problem)));
  constexpr std::size_t kMostGaussians =
      1500;  // the fit's matrices have 3 x 1500 rows, 160 MB each
  const std::size_t gaussians = choreography::gaussians(problem);
  if (gaussians == 0) {
    document.mismatch(*table.find("until"), "more time from the path's rest to the next");
  }
  if (gaussians > kMostGaussians) {
    document.fail_at_key(
        table,
        fmt::format("takes a curve of {} Gaussians, expected at most {}: waypoints farther apart, "
                    "or less time",
                    gaussians, kMostGaussians));
  }
  problem.pivot = number_or(table, "pivot", problem.pivot);
  if (const Value* limits = table.find("limits")) {
    problem.limits = read_limits(*limits);
    const Value* clearance = limits->find("clearance");
    if (clearance && !table.find("pivot")) {
      document.fail(*clearance,
                    "needs choreography.pivot, from where the forearm reaches to the hand");
    }
  }
  made.within = number_or(table, "within", kWithin);
  const Value& file = *table.find("file");
  const std::filesystem::path& stands = file.inherited ? document.base : document.file;
  made.file = stands.parent_path() / file.text;
  return made;
}

}  // namespace taut::scenes
