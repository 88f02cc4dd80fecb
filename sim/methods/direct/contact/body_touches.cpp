#include "sim/methods/direct/contact/body_touches.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/hash.h"

namespace taut::direct {
namespace {

using contact::kNoBody;
using contact::Spot;
using contact::SpotGap;
using contact::Vec6;
using ConstMap = Eigen::Map<const Vec3>;
using State = contact::Touch::State;

/// The motion of an obstacle's material at a place.
PointMotion surface(const FrameMotion& frame, const Vec3& at) {
  return frame.point(frame.rotation.conjugate() * (at - frame.position));
}

}  // namespace

void BodyTouches::rebuild(const World& world, std::span<const Obstacle> obstacles,
                          std::span<const BodyPair> pairs) {
  capsules_ = contact::capsules_of_free_bodies(world);
  meetings_ = contact::meetings_of_bodies(world, obstacles, pairs);
  bounding_radius_.clear();
  for (const BodyCapsule& capsule : capsules_) {
    const double far = std::max(capsule.from.norm(), capsule.to.norm()) + capsule.radius;
    bounding_radius_.push_back(capsule.touches() ? far : 0);
  }
  touches_.clear();
  before_.clear();
  places_.clear();
  mobility_.assign(capsules_.size(), contact::Mat6::Zero());
  coupled_.set_apart(mobility_);
  twists_.assign(capsules_.size(), Vec6::Zero());
  moves_ = twists_;
}

contact::Capsule BodyTouches::capsule(const double* pose, std::size_t body) const {
  const BodyCapsule& own = capsules_[body];
  const Quat rotation = quaternion(pose + 3).normalized();
  const Vec3 centre = ConstMap(pose);
  return {centre + rotation * own.from, centre + rotation * own.to, own.radius};
}

Pose BodyTouches::solid(const contact::BodyMeeting& meeting, std::span<const FrameMotion> frames,
                        const Mechanism& mechanism, const std::vector<double>& state) const {
  if (meeting.other == kNoBody) return frames[meeting.obstacle].pose();
  const double* pose = &state[mechanism.pose(meeting.other)];
  return contact::pose_of_solid(meeting, ConstMap(pose), quaternion(pose + 3).normalized());
}

Vec3 BodyTouches::foot(const contact::BodyMeeting& meeting, const contact::Capsule& own,
                       const SpotGap& near, const double* pose) const {
  const double apart = near.distance + own.radius + meeting.shape.radius;
  const Vec3 there = own.at(near.along) - apart * near.normal;
  return quaternion(pose + 3).conjugate() * (there - ConstMap(pose));
}

/// Tells a touch where its bodies touch.
void BodyTouches::aim_arms(const contact::Capsule& own, const SpotGap& near,
                           const Mechanism& mechanism, const std::vector<double>& state,
                           contact::BodyTouch& at) const {
  const Vec3 there = own.at(near.along) - own.radius * near.normal;
  at.arm = there - ConstMap(&state[mechanism.pose(at.body)]);
  if (at.other != kNoBody) at.other_arm = there - ConstMap(&state[mechanism.pose(at.other)]);
}

Vec3 BodyTouches::passing_at_start(const Step& step, const contact::BodyTouch& at) const {
  const Mechanism& mechanism = step.mechanism;
  const Vec3 moves = contact::velocity_at(twist_at(&step.state[mechanism.twist(at.body)]), at.arm);
  if (at.other != kNoBody) {
    return moves -
           contact::velocity_at(twist_at(&step.state[mechanism.twist(at.other)]), at.other_arm);
  }
  const Vec3 there = ConstMap(&step.state[mechanism.pose(at.body)]) + at.arm;
  return moves - surface(step.start[meetings_[at.meeting].obstacle], there).velocity;
}

bool BodyTouches::is_known(std::uint32_t meeting, std::size_t spot) const {
  return std::ranges::any_of(touches_, [&](const contact::BodyTouch& at) {
    return at.meeting == meeting && static_cast<std::size_t>(at.spot) == spot;
  });
}

bool BodyTouches::find(const Step& step, double least) {
  bool arrives = false;
  before_.swap(touches_);
  touches_.clear();
  places_.clear();
  for (std::uint32_t m = 0; m < meetings_.size(); ++m) {
    const contact::BodyMeeting& meeting = meetings_[m];
    const contact::Capsule own =
        capsule(&step.state[step.mechanism.pose(meeting.body)], meeting.body);
    const Pose frame = solid(meeting, step.start, step.mechanism, step.state);
    const double size = (own.to - own.from).norm();
    if (contact::gap_at(meeting.shape, frame, own, 0.5).distance > size) continue;
    const auto gaps = contact::all_gaps(meeting.shape, frame, own);
    for (const Spot spot : contact::kSpots) {
      const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
      if (!near.distinct || near.distance > step.touching) continue;
      contact::BodyTouch there{
          .body = meeting.body, .other = meeting.other, .meeting = m, .touch = {}};
      aim_arms(own, near, step.mechanism, step.state, there);
      const double leaving = near.normal.dot(passing_at_start(step, there));
      if (leaving > step.touching) continue;
      const bool hits = -leaving * meeting.restitution > least;
      arrives = arrives || hits;
      add(step, m, spot, hits);
    }
  }
  gather();
  return arrives;
}

void BodyTouches::add(const Step& step, const Hit& hit) {
  for (const Spot spot : contact::kSpots) {
    const auto index = static_cast<std::size_t>(spot);
    if (!(hit.spots & (1u << index)) || is_known(hit.meeting, index)) continue;
    add(step, hit.meeting, spot, true);
  }
  gather();
}

/// Adds a touch behind the ones before.
void BodyTouches::add(const Step& step, std::uint32_t index, Spot spot, bool hits) {
  const contact::BodyMeeting& meeting = meetings_[index];
  const contact::Capsule own =
      capsule(&step.state[step.mechanism.pose(meeting.body)], meeting.body);
  const Pose frame = solid(meeting, step.start, step.mechanism, step.state);
  const SpotGap near = contact::gap_at(meeting.shape, frame, own, spot);
  contact::BodyTouch made{
      .body = meeting.body, .other = meeting.other, .meeting = index, .spot = spot, .touch = {}};
  Place place{
      .hits = hits, .along_start = near.along, .start_normal = near.normal, .own = {}, .other = {}};
  if (meeting.other != kNoBody) {
    const double* pose = &step.state[step.mechanism.pose(meeting.other)];
    place.other_start = foot(meeting, own, near, pose);
  }
  made.touch.stick = meeting.static_friction;
  made.touch.slide = meeting.kinetic_friction;
  const bool stuck = std::ranges::any_of(before_, [&](const contact::BodyTouch& was) {
    return was.meeting == index && was.spot == spot && was.touch.state == State::sticks;
  });
  if (!stuck) {
    aim_arms(own, near, step.mechanism, step.state, made);
    made.touch.sliding = passing_at_start(step, made);
  }
  places_.push_back(place);
  touches_.push_back(made);
}

/// Puts touches in order of their clusters; they are few, and most are already.
void BodyTouches::gather() {
  clusters_.find(capsules_.size(), touches_);
  for (std::size_t end = 1; end < touches_.size(); ++end) {
    for (std::size_t i = end; i > 0; --i) {
      if (clusters_.of(touches_[i - 1]) <= clusters_.of(touches_[i])) break;
      std::swap(touches_[i - 1], touches_[i]);
      std::swap(places_[i - 1], places_[i]);
    }
  }
}

void BodyTouches::scale_friction(double share) {
  for (contact::BodyTouch& at : touches_) {
    at.touch.stick = share * meetings_[at.meeting].static_friction;
    at.touch.slide = share * meetings_[at.meeting].kinetic_friction;
  }
}

void BodyTouches::release() {
  for (contact::BodyTouch& at : touches_) {
    at.given.setZero();
    at.touch.push = 0;
    at.touch.state = State::open;
  }
  for (Place& place : places_) place.before.setZero();
}

std::uint64_t BodyTouches::pattern() const {
  Hash hash;
  for (const contact::BodyTouch& at : touches_) {
    hash.word(std::uint64_t(at.meeting)).word(static_cast<std::uint64_t>(at.spot));
    hash.word(static_cast<std::uint64_t>(at.touch.state));
  }
  return hash.value();
}

}  // namespace taut::direct
