#include "sim/interventions/feasible.h"

#include <algorithm>

#include "sim/topology/components.h"

namespace taut {
namespace {

/// The point of the way from `start` to `end` that is nearest to `to`.
Vec3 nearest(const Vec3& start, const Vec3& end, const Vec3& to) {
  const Vec3 way = end - start;
  const double length = way.squaredNorm();
  const double part = length > 0 ? std::clamp((to - start).dot(way) / length, 0.0, 1.0) : 0;
  return start + part * way;
}

/// Whether one hold lets it. As far and as near as it is already is never too much: methods leave
/// links a little too long.
Outcome allowed(const World& world, const Connector& connector, const Hold& hold,
                const DistanceRange& range, const Move& move) {
  const double same = kSamePlace * connector.length;
  if (move.drawn && !is_prescribed(world, hold.to)) return Outcome::done;
  const Vec3& there = connector.position[hold.particle];
  const double present = (move.now - there).norm();
  for (const Vec3& from : {there, goal(world, hold.to, hold.to.approach.arrival)}) {
    const double apart = (move.target - from).norm();
    const double nearing =
        move.drawn ? (nearest(move.now, move.target, from) - from).norm() : apart;
    if (apart > std::max(range.most, present) + same) return Outcome::out_of_reach;
    if (nearing < std::min(range.least, present) - same) return Outcome::too_near;
  }
  return Outcome::done;
}

}  // namespace

bool on(const Connector& connector, double along) {
  return along >= 0 && along <= connector.length * (1 + kSamePlace);
}

Vec3 goal(const World& world, const Attachment& to, double arrival) {
  return hold_motion(world, to, std::max(world.time, arrival)).position;
}

Outcome feasible(const World& world, const Connector& connector, const Place& place,
                 const Move& move) {
  if (connector.stretches()) return Outcome::done;
  const auto [particle, fraction] = place;
  double length = 0, longest = 0;
  const auto pass = [&](double piece) {
    length += piece;
    longest = std::max(longest, piece);
  };
  const auto look = [&](const Hold& hold) {
    const double least = connector.pulls ? 0 : std::max(0.0, 2 * longest - length);
    return allowed(world, connector, hold, {least, length}, move);
  };
  const std::vector<Hold>& holds = connector.holds;
  const auto behind = std::ranges::upper_bound(holds, particle, {}, &Hold::particle);
  if (fraction > 0) pass(fraction * connector.rest[particle]);
  std::size_t k = particle;
  for (auto hold = behind; hold != holds.begin();) {
    --hold;
    for (; k > hold->particle; --k) pass(connector.rest[k - 1]);
    if (hold->particle == particle && fraction == 0) continue;
    const Outcome outcome = look(*hold);
    if (outcome != Outcome::done) return outcome;
    if (is_prescribed(world, hold->to)) break;
  }
  length = longest = 0;
  k = particle;
  if (fraction > 0) pass((1 - fraction) * connector.rest[k++]);
  for (auto hold = behind; hold != holds.end(); ++hold) {
    for (; k < hold->particle; ++k) pass(connector.rest[k]);
    const Outcome outcome = look(*hold);
    if (outcome != Outcome::done) return outcome;
    if (is_prescribed(world, hold->to)) break;
  }
  return Outcome::done;
}

Joined join(const World& world, const Connector& connector, const JoinedSpan& span) {
  const double apart = (connector.position[span.last] - connector.position[span.first]).norm();
  const bool folds = apart >= 2 * span.longest - span.length - kSamePlace * connector.length;
  bool gives_way = false;
  for (const std::size_t end : {span.first, span.last}) {
    const Hold* hold = find_hold(connector, end);
    if (hold == nullptr) return Joined::straightens;
    gives_way |= !is_prescribed(world, hold->to);
  }
  if (folds) return Joined::straightens;
  return gives_way ? Joined::needs_a_body : Joined::bent;
}

}  // namespace taut
