// The twist of connectors among the forces of a world.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/material/forces.h"
#include "sim/world/twist.h"

namespace taut::material {
namespace {

/// The turn of a hold that is the farthest from none, rad.
double farthest(const Hold& hold) {
  double most = 0;
  if (!hold.turn) return most;
  for (const PathKey& key : hold.turn->keys()) most = std::max(most, std::abs(key.position.x()));
  return most;
}

}  // namespace

/// The twist of a connector that carries any; its clamps are numbered from `clamps` on.
void MaterialForces::add_twist(const Connector& connector, std::uint32_t index, std::uint32_t first,
                               std::uint32_t clamps, bool closed) {
  double softness = 0, damping = 0, rest = 0;
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const Section& section = connector.sections[k];
    const double own = connector.rest[k] / section.twisting_stiffness;  // rad for 1 N m
    softness += own;
    // Each link takes its share of the rate, as it takes its share of the twist.
    damping += own * section.twisting_damping / section.twisting_stiffness;
    rest += connector.rest[k] * section.rest_twist;
  }
  double most = std::abs(rest);
  for (const Hold& hold : connector.holds) most += farthest(hold);
  twists_.push_back({.connector = index,
                     .first = first,
                     .links = static_cast<std::uint32_t>(connector.links()),
                     .closed = closed,
                     .from = clamps,
                     .to = clamps + 1,
                     .stiffness = 1 / softness,
                     .damping = damping / (softness * softness),
                     .rest = rest,
                     .most = most,
                     .start = connector.end_turn.start,
                     .since = connector.end_turn.since});
}

/// Calls `visit(link, slope)`, slope the derivative of the twist by the link's edge.
template <class Visit>
void MaterialForces::each_slope(const TwistElement& rod, const double* positions,
                                Visit visit) const {
  Vec3 edge = link_of(rod, 0, positions), next;
  const Vec3 first =
      rod.closed ? link_of(rod, rod.links - 1, positions) : clamps_[rod.from].motion.direction;
  const Vec3 last = rod.closed ? edge : clamps_[rod.to].motion.direction;
  Vec3 before = Carry(first, edge).slope();
  for (std::uint32_t k = 0; k < rod.links; ++k) {
    next = k + 1 < rod.links ? link_of(rod, k + 1, positions) : last;
    const Vec3 behind = Carry(edge, next).slope();
    visit(k, Vec3((before + behind) / edge.norm()));
    before = behind;
    edge = next;
  }
}

Vec3 MaterialForces::link_of(const TwistElement& rod, std::uint32_t link,
                             const double* positions) const {
  const std::uint32_t a = point_of(rod, link), b = point_of(rod, link + 1);
  return Eigen::Map<const Vec3>(positions + 3 * b) - Eigen::Map<const Vec3>(positions + 3 * a);
}

double MaterialForces::turned(const TwistElement& rod, const double* positions) const {
  const auto direction = [&](std::uint32_t link) -> Vec3 {
    return link_of(rod, link, positions).normalized();
  };
  const Vec3 first = rod.closed ? direction(0) : clamps_[rod.from].motion.direction;
  const Vec3 last = rod.closed ? first : clamps_[rod.to].motion.direction;
  const Quat from = rod.closed ? frame_along(first) : clamps_[rod.from].frame.frame;
  const Quat to = rod.closed ? from : clamps_[rod.to].frame.frame;
  CarriedFrame carried(from, first);
  for (std::uint32_t k = 0; k < rod.links; ++k) carried.carry(direction(k));
  carried.carry(last);
  // As near to the last one as whole turns bring it.
  const double now = carried.turn_to(to) - rod.start;
  constexpr double kTurn = 2 * std::numbers::pi;
  return now + kTurn * std::round((rod.since - now) / kTurn);
}

double MaterialForces::twist(const TwistElement& rod, const double* positions) const {
  const double turn = turned(rod, positions) - rod.rest;
  return rod.closed ? turn : turn + clamps_[rod.to].frame.turn - clamps_[rod.from].frame.turn;
}

double MaterialForces::twist_rate(const TwistElement& rod, const double* positions,
                                  const double* velocities) const {
  double rate = 0;
  if (!rod.closed) {
    const Clamp &from = clamps_[rod.from], &to = clamps_[rod.to];
    const Carry first(from.motion.direction, link_of(rod, 0, positions));
    const Carry last(link_of(rod, rod.links - 1, positions), to.motion.direction);
    rate += to.frame.spin + to.frame.turn_rate - from.frame.spin - from.frame.turn_rate;
    rate += first.slope().dot(from.motion.rate) + last.slope().dot(to.motion.rate);
  }
  each_slope(rod, positions, [&](std::uint32_t link, const Vec3& slope) {
    rate += slope.dot(link_of(rod, link, velocities));
  });
  return rate;
}

void MaterialForces::twist_slope(const TwistElement& rod, const double* positions,
                                 std::vector<Vec3>& slope) const {
  slope.assign(rod.links + 1, Vec3::Zero());
  each_slope(rod, positions, [&](std::uint32_t link, const Vec3& by_edge) {
    slope[link] -= by_edge;
    slope[link + 1] += by_edge;
  });
  if (!rod.closed) return;  // else the last particle is the first
  slope.front() += slope.back();
  slope.back().setZero();
}

void MaterialForces::add_twists(const double* positions, const double* velocities,
                                std::vector<Vec3>& force) const {
  for (const TwistElement& rod : twists_) {
    double moment = rod.stiffness * twist(rod, positions);
    if (rod.damping > 0) moment += rod.damping * twist_rate(rod, positions, velocities);
    each_slope(rod, positions, [&](std::uint32_t link, const Vec3& slope) {
      force[point_of(rod, link)] += moment * slope;
      force[point_of(rod, link + 1)] -= moment * slope;
    });
  }
}

void MaterialForces::follow(const double* positions) {
  for (TwistElement& rod : twists_) rod.since = turned(rod, positions);
}

void MaterialForces::load_twists(const World& world) {
  for (TwistElement& rod : twists_) {
    const EndTurn& turn = world.connectors[rod.connector].end_turn;
    rod.start = turn.start;
    rod.since = turn.since;
  }
}

void MaterialForces::store_twists(World& world) const {
  for (const TwistElement& rod : twists_)
    world.connectors[rod.connector].end_turn.since = rod.since;
}

}  // namespace taut::material
