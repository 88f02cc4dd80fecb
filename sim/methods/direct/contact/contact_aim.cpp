// Where beads touch, in the first stage of a step at obstacles.
#include <algorithm>

#include "sim/methods/direct/contact/contact_step.h"
#include "sim/methods/direct/contact/entry.h"

namespace taut::direct {
/// Tells the touches of the first stage where the beads are.
void ContactStep::aim(double h) {
  for (BeadTouch& at : touches_) aim(at, position(next_, at.point), h);
}

/// A touch whose bead ends up at `to`.
void ContactStep::aim(BeadTouch& at, const Vec3& to, double h) const {
  const Obstacle& obstacle = (*obstacles_)[at.obstacle];
  const FrameMotion &start = start_[at.obstacle], &end = end_[at.obstacle];
  const Vec3 from = position(state_, at.point);
  SurfaceDistance near = gap(obstacle, end.pose(), to, radius_[at.point]);
  const Vec3 side = end.rotation * at.side;
  if (near.normal.dot(side) < 0) {  // on its way to a solution it came out on the other side
    near = {side.dot(to - end.pose().to_world(at.anchor)), side};
  }
  at.gap = near.distance;
  // Along the mean normal a bead that stays at a round surface moves no way at all.
  Vec3 normal = near.normal;
  if (!at.hits) normal += gap(obstacle, start.pose(), from, radius_[at.point]).normal;
  at.touch.normal = normal.squaredNorm() > 1 ? Vec3(normal.normalized()) : near.normal;
  const Vec3 local = end.rotation.conjugate() * (to - end.position);
  at.touch.surface = (to - start.pose().to_world(local)) / h;
  at.touch.least = (at.touch.normal.dot(to - from) - near.distance) / h;
  at.touch.pushed.setZero();
  at.touch.friction_before.setZero();
}

/// How the responses of beads at one surface change with where they end up, as it curves.
void ContactStep::bend(double h) {
  std::ranges::fill(bend_, Mat3::Zero());
  const double nudge = kNudge * touching_;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const BeadTouch& at = touches_[i];
    const auto pushes = [&](std::size_t k) {
      return k < touches_.size() && touches_[k].point == at.point && touches_[k].touch.push > 0;
    };
    if (!(at.touch.push > 0) || pushes(i + 1) || (i > 0 && pushes(i - 1))) continue;
    Mat3 normal;
    Vec3 least;
    for (int axis = 0; axis < 3; ++axis) {
      BeadTouch moved = at;
      aim(moved, position(next_, at.point) + nudge * Vec3::Unit(axis), h);
      normal.col(axis) = (moved.touch.normal - at.touch.normal) / nudge;
      least[axis] = (moved.touch.least - at.touch.least) / nudge;
    }
    bend_[at.point] =
        contact::response_to_turning(bare_[at.point], at.touch, normal, least, creep_);
  }
}

}  // namespace taut::direct
