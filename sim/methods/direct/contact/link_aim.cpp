// Where links touch, in both stages of a step.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/methods/direct/contact/entry.h"
#include "sim/methods/direct/contact/link_touches.h"

namespace taut::direct {
namespace {

using contact::Capsule;
using contact::SpotGap;

}  // namespace

void LinkTouches::aim(const Step& step, const std::vector<double>& next) {
  for (LinkTouch& at : touches_) {
    aim(at, step, capsule(step, next, at.link));
    set_mobility(at, step);
  }
}

/// A touch whose link ends up as `own`.
void LinkTouches::aim(LinkTouch& at, const Step& step, const Capsule& own) const {
  const FrameMotion &start = step.start[at.obstacle], &end = step.end[at.obstacle];
  SpotGap near = contact::gap_at(step.obstacles[at.obstacle].shape, end.pose(), own, at.spot);
  const Vec3 there = own.at(near.along);
  const Vec3 side = end.rotation * at.side;
  if (near.normal.dot(side) < 0) {  // on its way to a solution it came out on the other side
    near.distance = side.dot(there - end.pose().to_world(at.anchor));
    near.normal = side;
  }
  at.gap = near.distance;
  // Along the mean normal and at the mean share, a link that stays at a point moves no way at all.
  Vec3 normal = near.normal;
  at.share = near.along;
  if (!at.hits) {
    normal += at.normal_start;
    at.share = (at.share + at.share_start) / 2;
  }
  at.touch.normal = normal.squaredNorm() > 1 ? Vec3(normal.normalized()) : near.normal;
  const Vec3 local = end.rotation.conjugate() * (there - end.position);
  at.touch.surface = (there - start.pose().to_world(local)) / step.h;
  const Vec3 moves = own.at(at.share) - capsule(step, step.state, at.link).at(at.share);
  at.touch.least = (at.touch.normal.dot(moves) - near.distance) / step.h;
  at.touch.pushed.setZero();
  at.touch.friction_before.setZero();
}

bool LinkTouches::tips(const Step& step, const std::vector<double>& next) const {
  return std::ranges::any_of(touches_, [&](const LinkTouch& at) {
    const Shape& shape = step.obstacles[at.obstacle].shape;
    const Pose start = step.start[at.obstacle].pose(), end = step.end[at.obstacle].pose();
    const Capsule first = capsule(step, step.state, at.link), last = capsule(step, next, at.link);
    if (at.hits) return false;
    const double ends = 2 * at.share - at.share_start;  // its share is the mean
    return contact::tips(shape, start, first, at.share_start, end, last, ends);
  });
}

/// How a touch changes as the beads of its link end up elsewhere.
void LinkTouches::bend(const Step& step, const std::vector<double>& next, const LinkTouch& at,
                       std::span<const Vec3> velocity, double creep,
                       GlideSystem::LinkTouch& made) const {
  const double nudge = kNudge * step.touching;
  const std::uint32_t point = links_[at.link].first;
  const Vec3 moves = (1 - at.share) * velocity[point] + at.share * velocity[point + 1];
  const Vec3 free = moves - at.mobility * at.given;
  const Capsule own = capsule(step, next, at.link);
  const auto bend_by = [&](Vec3 Capsule::*end, Vec3& slope) {
    Mat3 normal;
    Vec3 least;
    for (int axis = 0; axis < 3; ++axis) {
      Capsule nudged = own;
      nudged.*end += nudge * Vec3::Unit(axis);
      LinkTouch moved = at;
      aim(moved, step, nudged);
      normal.col(axis) = (moved.touch.normal - at.touch.normal) / nudge;
      least[axis] = (moved.touch.least - at.touch.least) / nudge;
      slope[axis] = (moved.share - at.share) / nudge;
    }
    return contact::response_to_turning(free, at.touch, normal, least, creep);
  };
  made.bend_first = bend_by(&Capsule::from, made.slope_first);
  made.bend_next = bend_by(&Capsule::to, made.slope_next);
}

/// How fast (m/s) a link comes to what it hits. Links may pull it there for the rest of a step in
/// which it has been stopped: that is no speed of its own, see ContactStep::arriving().
double LinkTouches::arriving(const LinkTouch& at, const Step& step,
                             std::span<const Vec3> middle) const {
  const contact::Touch& touch = at.touch;
  const auto coming = [&](const Vec3& velocity) {
    return -touch.normal.dot(velocity - touch.surface);
  };
  const std::uint32_t point = links_[at.link].first;
  const Vec3 moves = (1 - at.share) * middle[point] + at.share * middle[point + 1];
  const double pulled = coming(moves - touch.pushed - touch.friction_before);
  if (!(touch.push > 0)) return pulled;
  const Vec3 falls = velocity(step, at.link, at.share) + step.h * step.mechanism.gravity();
  return std::min(pulled, std::max(coming(moves), coming(falls)));
}

void LinkTouches::aim_velocities(const Step& step, const std::vector<double>& next,
                                 std::span<const Vec3> middle, double least, bool located) {
  std::erase_if(touches_, [&](const LinkTouch& at) {
    return at.gap > (at.hits ? kShortOf * step.touching : step.touching);
  });
  for (LinkTouch& at : touches_) {
    const Obstacle& obstacle = step.obstacles[at.obstacle];
    const FrameMotion& end = step.end[at.obstacle];
    const Capsule own = capsule(step, next, at.link);
    const SpotGap near = contact::gap_at(obstacle.shape, end.pose(), own, at.spot);
    const double was = at.mobility;
    at.share = near.along;
    set_mobility(at, step);
    contact::Touch& touch = at.touch;
    const double twice = 2 * at.mobility / was;
    // What lasted until something hit has had its share of the step: an impact gives no more than
    // it.
    const double before = located && !at.hits ? 0 : twice;
    touch.pushed = before * touch.push * touch.normal;
    touch.friction_before = before * touch.friction;
    touch.normal = near.normal;
    const Vec3 there = own.at(near.along);
    touch.surface = end.point(end.rotation.conjugate() * (there - end.position)).velocity;
    touch.least = touch.normal.dot(touch.surface);
    at.given.setZero();
    at.kicked.setZero();
    if (!at.hits) continue;
    const double bounce = obstacle.restitution * arriving(at, step, middle);
    at.bounce = bounce > least ? bounce : 0;
    touch.least += at.bounce;
  }
}

bool LinkTouches::rebounds() const {
  return std::ranges::any_of(touches_, [](const LinkTouch& at) { return at.bounce > 0; });
}

void LinkTouches::stop_bounces() {
  for (LinkTouch& at : touches_) at.touch.least -= std::exchange(at.bounce, 0);
}

}  // namespace taut::direct
