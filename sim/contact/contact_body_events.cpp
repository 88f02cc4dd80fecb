// Free bodies in the smooth motion between events: its ends, and their consequences.
#include <algorithm>
#include <cmath>

#include "sim/contact/contact_motion.h"

namespace taut::contact {
namespace {

using ConstMap = Eigen::Map<const Vec3>;

constexpr double kSpare = 1e-9;     // of forces per mass: no event yet
constexpr double kFly = 1e-3;       // m/s^2, for what flies together without any force
constexpr double kArrives = 1e-10;  // m/s
constexpr double kFlat = 1e-12;     // rad/s: out of a plane by rounding
constexpr double kFar = 1;          // an event that is none
constexpr double kSame = 1e-6;      // of an axis: a spot so near to an end is that

/// A touch that is not aimed yet.
BodyTouch touch_of(std::span<const BodyMeeting> meetings, std::uint32_t index, Spot spot) {
  const BodyMeeting& meeting = meetings[index];
  BodyTouch made{
      .body = meeting.body, .other = meeting.other, .meeting = index, .spot = spot, .touch = {}};
  made.touch.stick = meeting.static_friction;
  made.touch.slide = meeting.kinetic_friction;
  return made;
}

Vec3 frame_velocity(const FrameMotion& frame, const Vec3& at) {
  return frame.velocity + frame.spin.cross(at - frame.position);
}

}  // namespace

void ContactMotion::body_events(const State& state, std::vector<double>& values) const {
  for (std::uint32_t m = 0; m < meetings_.size(); ++m) {
    const BodyMeeting& meeting = meetings_[m];
    const Capsule own = capsule(state, meeting.body);
    const auto gaps = all_gaps(meeting.shape, solid(meeting, state), own);
    for (const Spot spot : kSpots) {
      const auto is_here = [&](const BodyTouch& at) { return at.meeting == m && at.spot == spot; };
      if (std::ranges::any_of(body_touches_, is_here)) continue;
      const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
      double value = is_place(meeting, state, gaps, spot) ? near.distance + touching_ / 2 : kFar;
      if (value < 0) {
        BodyTouch there = touch_of(meetings_, m, spot);
        aim(there, state);
        value = crossing(value, near.normal.dot(passing(there, state)) >= -kStill);
      }
      values.push_back(value);
    }
  }
  for (const BodyTouch& at : body_touches_) {
    const double inverse_mass = this->inverse_mass(at), push = inverse_mass * at.touch.push;
    const double spare = kSpare * (stir(at) + std::abs(push));
    values.push_back(push + spare);
    if (is_part(at.body)) {
      part_events(at, state, values);
    } else if (at.spot != Spot::from && at.spot != Spot::to) {
      const BodyMeeting& meeting = meetings_[at.meeting];
      const Pose place = solid(meeting, state);
      const double along = gap_at(meeting.shape, place, capsule(state, at.body), at.spot).along;
      values.push_back(std::min(along, 1 - along) - kSame);
    }
    if (at.touch.stick == 0) continue;
    if (at.touch.state == Touch::State::sticks) {
      values.push_back(at.touch.stick * push - inverse_mass * at.touch.friction.norm() + spare);
    } else {
      values.push_back(passing(at, state).dot(at.touch.sliding) + still(at) / 2);
    }
  }
}

/// 1/kg, of what touches there.
double ContactMotion::inverse_mass(const BodyTouch& at) const {
  if (is_part(at.body)) {
    const Part& own = part(at.body);
    const double left = 1 - at.share;
    return left * left * inverse_mass(std::size_t(own.first)) +
           at.share * at.share * inverse_mass(std::size_t(own.next));
  }
  const double own = mechanism_.bodies()[at.body].inverse_mass;
  return at.other == kNoBody ? own : own + mechanism_.bodies()[at.other].inverse_mass;
}

/// m/s^2: what pulls and weighs there.
double ContactMotion::stir(const BodyTouch& at) const {
  const auto moves = [&](std::uint32_t body) {
    return body_free_[body].head<3>().norm() + body_pulled_[body].head<3>().norm();
  };
  if (!is_part(at.body)) {
    return at.other == kNoBody ? moves(at.body) : moves(at.body) + moves(at.other) + kFly;
  }
  double sum = kFly;
  for (const std::uint32_t p : {part(at.body).first, part(at.body).next}) {
    const std::uint32_t c = carrier(p);
    sum += c == kNoBody ? free_[p].norm() + pulled_[p].norm()
                        : moves(mechanism_.body_points()[c].body);
  }
  return sum;
}

/// Adds their places, and the ways in which they and what they touch go.
void ContactMotion::add_ways_of_bodies(const State& state, std::vector<Vec3>& places,
                                       std::vector<Vec3>& ways) const {
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    places.push_back(ConstMap(&state[mechanism_.pose(b)]));
    ways.push_back(twist(state, b).head<3>());
    if (!capsules_[b].touches()) continue;
    const Capsule own = capsule(state, b);
    places.push_back(own.from);
    places.push_back(own.to);
  }
  for (const BodyTouch& at : body_touches_) {
    const Vec3 there = where(at, state);
    places.push_back(there);
    ways.push_back(at.touch.normal);
    if (at.other != kNoBody) continue;
    ways.push_back(frame_velocity(frames_[meetings_[at.meeting].obstacle], there));
  }
}

/// Whether bodies turn about a direction alone, and go on to.
bool ContactMotion::turn_within(const State& state, const Vec3& normal) const {
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    const Vec3 spin = twist(state, b).tail<3>();
    const Vec3 eased = mechanism_.bodies()[b].world_inverse * normal;
    if (normal.cross(spin).norm() > kFlat) return false;
    if (normal.cross(eased).norm() > kFlat * eased.norm()) return false;
  }
  return true;
}

/// All that bodies touch and do not leave.
void ContactMotion::find_body_touches(const State& state) {
  body_touches_.clear();
  for (std::uint32_t m = 0; m < meetings_.size(); ++m) {
    const BodyMeeting& meeting = meetings_[m];
    const auto gaps = all_gaps(meeting.shape, solid(meeting, state), capsule(state, meeting.body));
    for (const Spot spot : kSpots) {
      const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
      if (near.distance > touching_ || !is_place(meeting, state, gaps, spot)) continue;
      BodyTouch found = touch_of(meetings_, m, spot);
      aim(found, state);
      const Vec3 slip = passing(found, state);
      const double separating = near.normal.dot(slip);
      // What leaves more slowly than bounces that are followed may be pushed back at once.
      const double leaves = parts_.empty() ? kArrives : slowest_;
      if (separating > leaves) continue;
      found.touch.sliding = slip - separating * near.normal;
      body_touches_.push_back(found);
    }
  }
  if (!parts_.empty()) leave_to_links();
  gather();
}

/// Puts the touches in order of their clusters.
void ContactMotion::gather() {
  if (!parts_.empty()) return;  // all are one
  clusters_.find(capsules_.size(), body_touches_);
  std::ranges::stable_sort(body_touches_, {},
                           [&](const BodyTouch& at) { return clusters_.of(at); });
}

/// Asks for velocities after an impact; whether a body arrives.
bool ContactMotion::bodies_arrive(const State& state) {
  free_bodies(&state);
  const Motion before{free_, body_free_};
  bool any = false;
  for (BodyTouch& at : body_touches_) {
    const BodyMeeting& meeting = meetings_[at.meeting];
    at.ahead.setZero();
    at.given.setZero();
    at.touch.surface.setZero();
    if (at.other == kNoBody) {
      at.touch.surface = frame_velocity(frames_[meeting.obstacle], where(at, state));
    }
    const double carried = at.touch.normal.dot(at.touch.surface);
    const double into = carried - at.touch.normal.dot(passing(before, at));
    any = any || into > kArrives;
    const double bounce = meeting.restitution * into;
    at.touch.least = carried + (bounce > slowest_ ? bounce : 0);
  }
  return any;
}

/// Asks for accelerations, before the active set is chosen.
void ContactMotion::ask_of_bodies(const State& state) {
  free_bodies(nullptr);
  for (BodyTouch& at : body_touches_) {
    aim(at, state);
    ask_accelerations(at, state);
    at.given.setZero();
    at.ahead.setZero();
    if (at.touch.sliding.norm() > still(at)) at.ahead = heading(at.touch.sliding, at.touch.sliding);
    at.touch.sliding.setZero();
  }
}

/// Takes the active set that was chosen.
void ContactMotion::take_touches() {
  std::erase_if(body_touches_,
                [](const BodyTouch& at) { return at.touch.state == Touch::State::open; });
  gather();
  const Motion after = after_impact();  // of accelerations
  for (BodyTouch& at : body_touches_) {
    if (at.touch.stick == 0) at.touch.state = Touch::State::slides;
    if (at.touch.state == Touch::State::sticks) continue;
    if (at.ahead.isZero(0)) {
      const Vec3 slip = passing(after, at) - at.touch.surface;
      const Vec3 across = slip - at.touch.normal.dot(slip) * at.touch.normal;
      if (across.squaredNorm() > 0) at.ahead = heading(across, across);
    }
    at.touch.sliding = at.ahead;
  }
}

}  // namespace taut::contact
