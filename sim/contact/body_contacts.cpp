#include "sim/contact/body_contacts.h"

#include <algorithm>

namespace taut::contact {
namespace {

constexpr double kUnchanged = 1e-6;  // of the greatest twist: a change as good as none

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

Eigen::Map<Vec6> twist(double* at) {
  return Eigen::Map<Vec6>(at);
}

Pose pose_of(const Mechanism& mechanism, std::uint32_t body, const std::vector<double>& state) {
  const double* q = &state[mechanism.pose(body)];
  return {ConstMap(q), quaternion(q + 3)};
}

Capsule placed(const BodyCapsule& capsule, const Pose& at) {
  return {at.to_world(capsule.from), at.to_world(capsule.to), capsule.radius};
}

/// m/s, what gravity alone may make in a step.
double resting_speed(const Mechanism& mechanism, double dt) {
  return 2 * dt * mechanism.gravity().norm();
}

/// Whether a capsule is farther than `near` (m) from a solid, as its middle tells: distances change
/// no faster than places.
bool is_far(const Shape& shape, const Pose& frame, const Capsule& capsule, double near) {
  const Vec3 middle = frame.rotation.conjugate() * (capsule.at(0.5) - frame.position);
  const double reach = (capsule.to - capsule.from).norm() / 2 + capsule.radius;
  return shape.from(middle).distance > reach + near;
}

/// How far a body's point has moved since `before` (m).
Vec3 moved(const Mechanism& mechanism, std::uint32_t body, const Vec3& arm,
           const std::vector<double>& before, const std::vector<double>& state) {
  const Pose now = pose_of(mechanism, body, state), old = pose_of(mechanism, body, before);
  return now.position + arm - old.to_world(now.rotation.conjugate() * arm);
}

}  // namespace

void BodyContacts::rebuild(const Mechanism& mechanism, const World& world) {
  meetings_.clear();
  if (!has_touching_bodies(world)) return;
  obstacles_ = world.obstacles;
  capsules_ = capsules_of_free_bodies(world);
  meetings_ = meetings_of_bodies(world, obstacles_, world.pairs);
  frames_.reserve(obstacles_.size());
  touches_.reserve(kSpots.size() * meetings_.size());
  masses_.reserve(touches_.capacity());
  mobility_.reserve(mechanism.bodies().size());
  twists_.reserve(mechanism.bodies().size());
}

void BodyContacts::find(const Mechanism& mechanism, double time, double dt,
                        const std::vector<double>& state) {
  // In a pile all fall alike, and what moves the lowest out moves it into the next.
  const double near = dt * resting_speed(mechanism, dt);
  frames_.clear();
  for (const Obstacle& obstacle : obstacles_) frames_.push_back(obstacle.frame(time));
  touches_.clear();
  for (std::size_t m = 0; m < meetings_.size(); ++m) {
    const BodyMeeting& meeting = meetings_[m];
    const Capsule capsule =
        placed(capsules_[meeting.body], pose_of(mechanism, meeting.body, state));
    Pose solid;
    if (meeting.other == kNoBody) {
      solid = frames_[meeting.obstacle].pose();
    } else {
      const Pose other = pose_of(mechanism, meeting.other, state);
      solid = pose_of_solid(meeting, other.position, other.rotation);
    }
    if (is_far(meeting.shape, solid, capsule, near)) continue;
    const auto gaps = all_gaps(meeting.shape, solid, capsule);
    const auto touches = [&](const SpotGap& gap) { return gap.distance <= near; };
    if (std::ranges::none_of(gaps, touches)) continue;
    // What moves one spot out may move another in: all of them count.
    for (const Spot spot : kSpots) {
      const SpotGap& gap = gaps[static_cast<std::size_t>(spot)];
      if (gap.distinct) add(mechanism, m, capsule, spot, gap, state);
    }
  }
  find_masses(mechanism, state);
}

void BodyContacts::add(const Mechanism& mechanism, std::size_t index, const Capsule& capsule,
                       Spot spot, const SpotGap& gap, const std::vector<double>& state) {
  const BodyMeeting& meeting = meetings_[index];
  const Vec3 point = capsule.at(gap.along) - capsule.radius * gap.normal;
  const Vec3 origin = meeting.other == kNoBody ? frames_[meeting.obstacle].position
                                               : pose_of(mechanism, meeting.other, state).position;
  BodyTouch& at = touches_.emplace_back();
  at.body = meeting.body;
  at.other = meeting.other;
  at.meeting = small(index);
  at.spot = spot;
  at.arm = point - pose_of(mechanism, meeting.body, state).position;
  at.other_arm = point - origin;
  at.touch.normal = gap.normal;
  at.touch.least = -gap.distance;
}

void BodyContacts::find_masses(const Mechanism& mechanism, const std::vector<double>& state) {
  masses_.clear();
  if (touches_.empty()) return;
  mobility_.clear();
  for (std::uint32_t b = 0; b < capsules_.size(); ++b) {
    const auto& body = mechanism.bodies()[b];
    const Mat3 turn = pose_of(mechanism, b, state).rotation.toRotationMatrix();
    const Mat3 inverse = turn * body.inverse_inertia * turn.transpose();
    mobility_.push_back(mobility(body.inverse_mass, inverse));
  }
  for (const BodyTouch& at : touches_) masses_.push_back(effective_mass(mobility_, at));
}

Vec3 BodyContacts::surface_velocity(const BodyTouch& at) const {
  if (at.other != kNoBody) return Vec3::Zero();
  const FrameMotion& frame = frames_[meetings_[at.meeting].obstacle];
  return frame.velocity + frame.spin.cross(at.other_arm);
}

void BodyContacts::use_friction(bool used) {
  for (BodyTouch& at : touches_) {
    const BodyMeeting& meeting = meetings_[at.meeting];
    at.touch.stick = used ? meeting.static_friction : 0;
    at.touch.slide = used ? meeting.kinetic_friction : 0;
  }
}

/// Moves bodies and what they carry, and forgets the touches that stay open.
void BodyContacts::shift(const Mechanism& mechanism, std::vector<double>& state) {
  twists_.assign(capsules_.size(), Vec6::Zero());
  relax(mobility_, masses_, touches_, twists_);
  for (std::uint32_t b = 0; b < twists_.size(); ++b) {
    if (twists_[b].isZero(0)) continue;
    double* q = &state[mechanism.pose(b)];
    Map(q) += twists_[b].head<3>();
    rotate(twists_[b].tail<3>(), q + 3);
  }
  for (const auto& carried : mechanism.body_points()) {
    if (twists_[carried.body].isZero(0)) continue;
    Map place(&state[mechanism.position(carried.point)]);
    place = pose_of(mechanism, carried.body, state).to_world(carried.local);
  }
  std::size_t closed = 0;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const BodyTouch& at = touches_[i];
    const bool open =
        at.given.isZero(0) && at.touch.normal.dot(passing(twists_, at)) > at.touch.least;
    if (open) continue;
    touches_[closed] = at;
    masses_[closed++] = masses_[i];
  }
  touches_.resize(closed);
  masses_.resize(closed);
}

void BodyContacts::move_out(const Mechanism& mechanism, double time, double dt,
                            const std::vector<double>& before, std::vector<double>& state) {
  find(mechanism, time, dt, state);
  if (touches_.empty()) return;
  for (BodyTouch& at : touches_) {
    at.touch.surface = dt * surface_velocity(at) - moved(mechanism, at.body, at.arm, before, state);
    if (at.other == kNoBody) continue;
    at.touch.surface += moved(mechanism, at.other, at.other_arm, before, state);
  }
  use_friction(true);
  shift(mechanism, state);
}

/// The velocities with which touches are to end, as they came with those of `came`. True where
/// some came faster than gravity makes them.
bool BodyContacts::find_rebounds(const Mechanism& mechanism, double dt,
                                 const std::vector<double>& came) {
  for (std::uint32_t b = 0; b < twists_.size(); ++b) {
    twists_[b] = Eigen::Map<const Vec6>(&came[mechanism.twist(b)]);
  }
  const double resting = resting_speed(mechanism, dt);
  bool struck = false;
  for (BodyTouch& at : touches_) {
    Touch& touch = at.touch;
    touch.surface = surface_velocity(at);
    const double into = touch.normal.dot(touch.surface - passing(twists_, at));
    const double back = into > resting ? meetings_[at.meeting].restitution * into : 0;
    touch.least = touch.normal.dot(touch.surface) + back;
    struck = struck || into > resting;
  }
  return struck;
}

bool BodyContacts::push(const Mechanism& mechanism, std::vector<double>& state) {
  for (std::uint32_t b = 0; b < twists_.size(); ++b) twists_[b] = twist(&state[mechanism.twist(b)]);
  relax(mobility_, masses_, touches_, twists_);
  double changed = 0, most = 0;
  for (std::uint32_t b = 0; b < twists_.size(); ++b) {
    auto now = twist(&state[mechanism.twist(b)]);
    changed = std::max(changed, (twists_[b] - now).norm());
    most = std::max(most, twists_[b].norm());
    now = twists_[b];
  }
  return changed <= kUnchanged * most;
}

bool BodyContacts::rebound(const Mechanism& mechanism, double dt, const std::vector<double>& before,
                           std::vector<double>& state) {
  if (touches_.empty()) return false;
  const bool struck = find_rebounds(mechanism, dt, before);
  for (BodyTouch& at : touches_) at.given /= dt;
  push(mechanism, state);
  return struck;
}

void BodyContacts::stop(const Mechanism& mechanism, double time, double dt,
                        std::vector<double>& state) {
  find(mechanism, time, dt, state);
  if (touches_.empty()) return;
  use_friction(false);
  shift(mechanism, state);
  find_rebounds(mechanism, dt, state);
  use_friction(true);
  for (BodyTouch& at : touches_) at.given.setZero();
  push(mechanism, state);
}

}  // namespace taut::contact
