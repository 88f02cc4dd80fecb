#include "sim/methods/direct/contact/bead_touches.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/hash.h"

namespace taut::direct {
namespace {

using contact::BodyMeeting;
using contact::SpotGap;
using contact::Vec6;
using ConstMap = Eigen::Map<const Vec3>;
using State = contact::Touch::State;

}  // namespace

void BeadTouches::rebuild(const World& world, const Mechanism& mechanism,
                          std::span<const BeadPair> pairs) {
  touches_.clear();
  before_.clear();
  hits_.clear();
  reach_.clear();
  radius_.clear();
  bounding_radius_.clear();
  meetings_ = contact::meetings_of_beads(world, mechanism, pairs);
  std::vector<double> radius;
  for (const Connector& connector : world.connectors) {
    radius.insert(radius.end(), connector.particles(), connector.radius);
  }
  for (const BodyCapsule& capsule : contact::capsules_of_free_bodies(world)) {
    const double far = std::max(capsule.from.norm(), capsule.to.norm()) + capsule.radius;
    bounding_radius_.push_back(far);
  }
  for (const BodyMeeting& meeting : meetings_) {
    radius_.push_back(radius[meeting.body]);
    reach_.push_back(bounding_radius_[meeting.other] + radius[meeting.body]);
  }
}

/// The gap of a bead at the body that is there.
SpotGap BeadTouches::gap_of(const BodyMeeting& meeting, std::uint32_t index, const Vec3& bead,
                            const double* pose) const {
  const Pose solid =
      contact::pose_of_solid(meeting, ConstMap(pose), quaternion(pose + 3).normalized());
  const contact::Capsule own{bead, bead, radius_[index]};
  return contact::gap_at(meeting.shape, solid, own, contact::Spot::from);
}

/// Whether a bead is farther than `near` (m) from a body where the step begins, as that one's size
/// tells.
bool BeadTouches::is_far(const Step& step, std::uint32_t index, double near) const {
  const BodyMeeting& meeting = meetings_[index];
  const ConstMap bead(&step.state[step.mechanism.position(meeting.body)]);
  const ConstMap centre(&step.state[step.mechanism.pose(meeting.other)]);
  const double reach = reach_[index] + near;
  return (bead - centre).squaredNorm() > reach * reach;
}

bool BeadTouches::is_known(std::uint32_t meeting) const {
  return std::ranges::any_of(touches_, [&](const BeadTouch& at) { return at.meeting == meeting; });
}

/// m/s: how a bead moves past the body's surface where the step begins.
Vec3 BeadTouches::passing_at_start(const Step& step, const BeadTouch& at) const {
  const Mechanism& mechanism = step.mechanism;
  const ConstMap moves(&step.state[mechanism.velocity(at.point)]);
  return moves -
         contact::velocity_at(twist_at(&step.state[mechanism.twist(at.body)]), at.start_arm);
}

bool BeadTouches::find(const Step& step, double least) {
  bool arrives = false;
  before_.swap(touches_);
  touches_.clear();
  for (std::uint32_t m = 0; m < meetings_.size(); ++m) {
    if (is_far(step, m, step.touching)) continue;
    const BodyMeeting& meeting = meetings_[m];
    const Vec3 bead = ConstMap(&step.state[step.mechanism.position(meeting.body)]);
    const double* pose = &step.state[step.mechanism.pose(meeting.other)];
    const SpotGap near = gap_of(meeting, m, bead, pose);
    if (near.distance > step.touching) continue;
    const Quat back = quaternion(pose + 3).conjugate();
    BeadTouch made{.point = meeting.body,
                   .body = meeting.other,
                   .meeting = m,
                   .anchor = back * (bead - ConstMap(pose)),
                   .side = back * near.normal,
                   .normal_start = near.normal,
                   .foot = Vec3::Zero(),
                   .down = Vec3::Zero(),
                   .place = Vec3::Zero(),
                   .start_arm = bead - radius_[m] * near.normal - ConstMap(pose),
                   .arm = Vec3::Zero()};
    const double leaving = near.normal.dot(passing_at_start(step, made));
    if (leaving > step.touching) continue;
    made.hits = -leaving * meeting.restitution > least;
    arrives = arrives || made.hits;
    add(step, made);
  }
  return arrives;
}

void BeadTouches::add(const Step& step, const Hit& hit) {
  if (is_known(hit.meeting)) return;
  const BodyMeeting& meeting = meetings_[hit.meeting];
  const Vec3 bead = ConstMap(&step.state[step.mechanism.position(meeting.body)]);
  const double* pose = &step.state[step.mechanism.pose(meeting.other)];
  const Vec3 normal = gap_of(meeting, hit.meeting, bead, pose).normal;
  add(step, {.point = meeting.body,
             .body = meeting.other,
             .meeting = hit.meeting,
             .hits = true,
             .anchor = hit.anchor,
             .side = hit.side,
             .normal_start = normal,
             .foot = Vec3::Zero(),
             .down = Vec3::Zero(),
             .place = Vec3::Zero(),
             .start_arm = bead - radius_[hit.meeting] * normal - ConstMap(pose),
             .arm = Vec3::Zero()});
}

/// Adds a touch where it stands in order.
void BeadTouches::add(const Step& step, BeadTouch made) {
  const BodyMeeting& meeting = meetings_[made.meeting];
  made.touch.stick = meeting.static_friction;
  made.touch.slide = meeting.kinetic_friction;
  const bool stuck = std::ranges::any_of(before_, [&](const BeadTouch& was) {
    return was.meeting == made.meeting && was.touch.state == State::sticks;
  });
  if (!stuck) made.touch.sliding = passing_at_start(step, made);
  touches_.insert(std::ranges::upper_bound(touches_, made.point, {}, &BeadTouch::point), made);
}

bool BeadTouches::thrown_back_within(double share) const {
  return std::ranges::any_of(hits_, [&](const Hit& hit) {
    return hit.share <= share && meetings_[hit.meeting].restitution > 0;
  });
}

void BeadTouches::scale_friction(double share) {
  for (BeadTouch& at : touches_) {
    at.touch.stick = share * meetings_[at.meeting].static_friction;
    at.touch.slide = share * meetings_[at.meeting].kinetic_friction;
  }
}

void BeadTouches::release() {
  take_back_kicks();
  for (BeadTouch& at : touches_) {
    at.given.setZero();
    at.touch.push = 0;
    at.touch.state = State::open;
  }
}

void BeadTouches::keep() {
  kept_.clear();
  for (const BeadTouch& at : touches_) kept_.push_back(at.given);
}

void BeadTouches::restore() {
  for (std::size_t i = 0; i < touches_.size(); ++i) touches_[i].given = kept_[i];
}

void BeadTouches::give(std::span<const double> inverse_mass, std::span<Vec3> velocity) const {
  for (const BeadTouch& at : touches_) velocity[at.point] += inverse_mass[at.point] * at.given;
}

void BeadTouches::kick(const Mechanism& mechanism, std::span<const Mat3> inverse,
                       std::vector<double>& twists) const {
  for (const BeadTouch& at : touches_) {
    Eigen::Map<Vec6> u(&twists[mechanism.twist(at.body)]);
    u.head<3>() -= mechanism.bodies()[at.body].inverse_mass * at.given;
    u.tail<3>() -= inverse[at.body] * at.start_arm.cross(at.given);
  }
}

void BeadTouches::kick_more(const Mechanism& mechanism, std::vector<double>& twists) {
  for (BeadTouch& at : touches_) {
    const auto& body = mechanism.bodies()[at.body];
    const Vec3 more = at.given - at.kicked;
    Eigen::Map<Vec6> u(&twists[mechanism.twist(at.body)]);
    u.head<3>() -= body.inverse_mass * more;
    u.tail<3>() -= body.world_inverse * at.arm.cross(more);
    at.kicked = at.given;
  }
}

void BeadTouches::take_back_kicks() {
  for (BeadTouch& at : touches_) at.kicked.setZero();
}

/// By how much a touch breaks its law, as its bead moves `past` (m/s) the body.
void BeadTouches::find_error(BeadTouch& at, const Vec3& past, double creep) {
  at.free = past - at.mobility * at.given;
  const contact::Response found = contact::respond(at.free, std::span(&at.touch, 1), creep);
  at.error = found.velocity - past;
  at.derivative = found.derivative;
}

void BeadTouches::find_errors(const Step& step, const std::vector<double>& next,
                              std::span<const Vec3> mean, double creep) {
  for (BeadTouch& at : touches_) {
    const double* from = &step.state[step.mechanism.pose(at.body)];
    const double* to = &next[step.mechanism.pose(at.body)];
    const Quat before = quaternion(from + 3), after = quaternion(to + 3);
    const Vec3 spin = angle(after * before.conjugate()) / step.h;
    const Vec3 moves = ConstMap(to) + after * at.foot - ConstMap(from) - before * at.foot;
    find_error(at, mean[at.point] - moves / step.h - spin.cross(at.down), creep);
  }
}

void BeadTouches::find_errors(const Mechanism& mechanism, std::span<const Vec3> velocity,
                              const std::vector<double>& twists, const BodyTouches& added,
                              double creep) {
  for (BeadTouch& at : touches_) {
    Vec6 twist = twist_at(&twists[mechanism.twist(at.body)]);
    if (added.any()) twist += added.added(at.body);
    find_error(at, velocity[at.point] - contact::velocity_at(twist, at.arm), creep);
  }
}

double BeadTouches::error(std::span<const double> noise) const {
  double worst = 0;
  for (const BeadTouch& at : touches_) {
    worst = std::max(worst, at.error.norm() - noise[at.point]);
  }
  return worst;
}

void BeadTouches::linearize() {
  linear_.clear();
  missing_.clear();
  for (const BeadTouch& at : touches_) {
    linear_.push_back({.point = at.point,
                       .body = at.body,
                       .arm = at.arm,
                       .mobility = at.mobility,
                       .derivative = at.derivative,
                       .bend = Mat3::Zero()});
    missing_.push_back(-at.error);
  }
}

void BeadTouches::advance(double share) {
  for (std::size_t i = 0; i < touches_.size(); ++i) touches_[i].given += share * missing_[i];
}

double BeadTouches::residual(const Mechanism& mechanism, const std::vector<double>& next) const {
  double worst = 0;
  for (const BeadTouch& at : touches_) {
    const double* pose = &next[mechanism.pose(at.body)];
    const Vec3 place = ConstMap(pose) + quaternion(pose + 3) * at.foot;
    worst = std::max({worst, at.touch.push > 0 ? std::abs(at.gap) : -at.gap,
                      (place - at.place).lpNorm<Eigen::Infinity>()});
  }
  return worst;
}

double BeadTouches::most_stuck() const {
  double most = 0;
  for (const BeadTouch& at : touches_) {
    if (at.touch.state == State::sticks) most = std::max(most, at.touch.friction.norm());
  }
  return most;
}

std::uint64_t BeadTouches::pattern() const {
  Hash hash;
  for (const BeadTouch& at : touches_) {
    hash.word(std::uint64_t(at.meeting)).word(static_cast<std::uint64_t>(at.touch.state));
  }
  return hash.value();
}

}  // namespace taut::direct
