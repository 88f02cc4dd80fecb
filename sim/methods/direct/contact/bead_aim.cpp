// Where beads touch free bodies, in both stages of a step.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/methods/direct/contact/bead_touches.h"
#include "sim/methods/direct/contact/entry.h"

namespace taut::direct {
namespace {

using contact::SpotGap;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kShortOfBody = 2000;  // times touching: as of two bodies, whose ways are foretold

}  // namespace

/// A touch whose bead ends up at `to`, and its body so.
void BeadTouches::aim(BeadTouch& at, const Step& step, const double* pose, const Vec3& to) const {
  const contact::BodyMeeting& meeting = meetings_[at.meeting];
  const double* from = &step.state[step.mechanism.pose(at.body)];
  const Quat before = quaternion(from + 3), after = quaternion(pose + 3);
  const double radius = radius_[at.meeting], solid = meeting.shape.radius;
  SpotGap near = gap_of(meeting, at.meeting, to, pose);
  const Vec3 foot = to - (near.distance + radius + solid) * near.normal;
  at.foot = after.conjugate() * (foot - ConstMap(pose));
  const Vec3 side = after * at.side;
  if (near.normal.dot(side) < 0) {  // on its way to a solution it came out on the other side
    near.distance = side.dot(to - ConstMap(pose) - after * at.anchor);
    near.normal = side;
  }
  at.gap = near.distance;
  // Along the mean normal a bead that stays at a round body moves no way at all.
  Vec3 normal = near.normal;
  if (!at.hits) normal += at.normal_start;
  at.touch.normal = normal.squaredNorm() > 1 ? Vec3(normal.normalized()) : near.normal;
  at.down = solid * at.touch.normal;
  at.place = foot;
  // The bead's way has its middle where the means of these are: momenta are kept.
  const Vec3 start = ConstMap(&step.state[step.mechanism.position(at.point)]);
  at.start_arm = start - radius * at.touch.normal - ConstMap(from);
  at.arm = to - radius * at.touch.normal - ConstMap(pose);
  const Vec3 body_moves = ConstMap(pose) + after * at.foot - ConstMap(from) - before * at.foot;
  at.touch.surface.setZero();
  at.touch.least = (at.touch.normal.dot(to - start - body_moves) - near.distance) / step.h;
  at.touch.pushed.setZero();
  at.touch.friction_before.setZero();
}

double BeadTouches::aim(const Step& step, const std::vector<double>& next) {
  double turned = 0;
  for (BeadTouch& at : touches_) {
    const double* pose = &next[step.mechanism.pose(at.body)];
    const double* from = &step.state[step.mechanism.pose(at.body)];
    turned =
        std::max(turned, angle(quaternion(pose + 3) * quaternion(from + 3).conjugate()).norm());
    aim(at, step, pose, ConstMap(&next[step.mechanism.position(at.point)]));
    set_mobility(at, step.mechanism);
  }
  return turned;
}

void BeadTouches::set_mobility(BeadTouch& at, const Mechanism& mechanism) const {
  const auto& body = mechanism.bodies()[at.body];
  const Vec3 turn = at.arm.cross(at.touch.normal);
  at.mobility =
      mechanism.inverse_mass()[at.point] + body.inverse_mass + turn.dot(body.world_inverse * turn);
}

void BeadTouches::linearize(const Step& step, const std::vector<double>& next,
                            std::span<const Vec3> behind, double creep) {
  linearize();
  const double nudge = kNudge * step.touching;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const BeadTouch& at = touches_[i];
    const Vec3 late = behind[at.point];
    missing_[i] += at.derivative * late - late;
    if (!(at.touch.push > 0)) continue;
    // How the touch changes as the bead ends up elsewhere.
    const double* pose = &next[step.mechanism.pose(at.body)];
    const Vec3 to = ConstMap(&next[step.mechanism.position(at.point)]);
    Mat3 normal;
    Vec3 least;
    for (int axis = 0; axis < 3; ++axis) {
      BeadTouch moved = at;
      aim(moved, step, pose, to + nudge * Vec3::Unit(axis));
      normal.col(axis) = (moved.touch.normal - at.touch.normal) / nudge;
      least[axis] = (moved.touch.least - at.touch.least) / nudge;
    }
    linear_[i].bend = contact::response_to_turning(at.free, at.touch, normal, least, creep);
  }
}

/// How fast (m/s) a bead comes to the body that it hits, where it moves `past` that now, and did
/// `before` the step. Links may pull it there for the rest of a step in which it has been stopped:
/// that is no speed of its own, see ContactStep::arriving().
double BeadTouches::arriving(const BeadTouch& at, const Mechanism& mechanism, const Vec3& past,
                             const Vec3& before, const Vec3& given) const {
  const auto coming = [&](const Vec3& velocity) { return -at.touch.normal.dot(velocity); };
  const auto& body = mechanism.bodies()[at.body];
  const Vec3 own = (mechanism.inverse_mass()[at.point] + body.inverse_mass) * given +
                   (body.world_inverse * at.arm.cross(given)).cross(at.arm);
  const double pulled = coming(past - own);
  if (!(at.touch.push > 0)) return pulled;
  return std::min(pulled, std::max(coming(past), coming(before)));
}

void BeadTouches::aim_velocities(const Step& step, const std::vector<double>& next,
                                 std::span<const Vec3> middle, double least, bool located) {
  const Mechanism& mechanism = step.mechanism;
  std::erase_if(touches_, [&](const BeadTouch& at) {
    return at.gap > (at.hits ? kShortOfBody * step.touching : step.touching);
  });
  for (BeadTouch& at : touches_) {
    const contact::BodyMeeting& meeting = meetings_[at.meeting];
    const double* pose = &next[mechanism.pose(at.body)];
    const Vec3 to = ConstMap(&next[mechanism.position(at.point)]);
    contact::Touch& touch = at.touch;
    const Vec3 given = 2 * at.given;
    const double was = at.mobility;
    const Vec3 normal = touch.normal;
    touch.normal = gap_of(meeting, at.meeting, to, pose).normal;
    at.arm = to - radius_[at.meeting] * touch.normal - ConstMap(pose);
    set_mobility(at, mechanism);
    // What lasted until something hit has had its share of the step, see LinkTouches.
    const double before = located && !at.hits ? 0 : 2 * at.mobility / was;
    // The push along the mean normal turns the way of sliding: it is found anew along this one.
    touch.pushed = before * touch.push * normal.dot(touch.normal) * touch.normal;
    touch.friction_before = before * touch.friction;
    touch.least = 0;
    at.given.setZero();
    at.kicked.setZero();
    if (!at.hits) continue;
    const auto past = [&](const Vec3& velocity, const std::vector<double>& state) -> Vec3 {
      return velocity - contact::velocity_at(twist_at(&state[mechanism.twist(at.body)]), at.arm);
    };
    const Vec3 now = past(middle[at.point], next);
    const Vec3 then = past(ConstMap(&step.state[mechanism.velocity(at.point)]), step.state);
    const double bounce = meeting.restitution * arriving(at, mechanism, now, then, given);
    at.bounce = bounce > least ? bounce : 0;
    touch.least += at.bounce;
  }
}

bool BeadTouches::rebounds() const {
  return std::ranges::any_of(touches_, [](const BeadTouch& at) { return at.bounce > 0; });
}

void BeadTouches::stop_bounces() {
  for (BeadTouch& at : touches_) at.touch.least -= std::exchange(at.bounce, 0);
}

}  // namespace taut::direct
