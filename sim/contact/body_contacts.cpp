#include "sim/contact/body_contacts.h"

#include <Eigen/LU>
#include <algorithm>

#include "sim/motion/stop.h"

namespace taut::contact {
namespace {

constexpr int kMostSweeps = 50;
constexpr double kSettled = 1e-8;  // of what is given: a sweep that changes less is the last

void give(std::span<const Mat6> mobility, const BodyTouch& at, const Vec3& impulse,
          std::span<Vec6> twists) {
  twists[at.body] += mobility[at.body] * wrench(impulse, at.arm);
  if (at.other == kNoBody) return;
  twists[at.other] -= mobility[at.other] * wrench(impulse, at.other_arm);
}

/// The friction of a touch that has `before` and slips: what stops it, or else the cone's point
/// next to a step against the slip, so that it ends where both point opposite ways.
Vec3 friction_after(const Touch& touch, const EffectiveMass& mass, const Vec3& before,
                    const Vec3& slip, double push) {
  const double most = (touch.state == Touch::State::slides ? touch.slide : touch.stick) * push;
  const Vec3 stopping = before - mass.across * slip;
  if (stopping.norm() <= most) return stopping;
  const Vec3 against = before - mass.least_across * slip;
  return std::min(1.0, most / against.norm()) * against;
}

/// Goes through the touches until they change little.
void sweep(std::span<const Mat6> mobility, std::span<const EffectiveMass> masses,
           std::span<BodyTouch> touches, std::span<Vec6> twists) {
  for (int i = 0; i < kMostSweeps; ++i) {
    check_stop();
    double most = 0, changed = 0;
    for (std::size_t t = 0; t < touches.size(); ++t) {
      BodyTouch& at = touches[t];
      const Vec3 &normal = at.touch.normal, before = at.given;
      const double pushed = normal.dot(before);
      const Vec3 rubbed = before - pushed * normal;
      const double missing = at.touch.least - normal.dot(passing(twists, at));
      const double push = std::max(0.0, pushed + masses[t].along * missing);
      give(mobility, at, (push - pushed) * normal, twists);

      const Vec3 slip = across(normal) * (passing(twists, at) - at.touch.surface);
      const Vec3 friction = friction_after(at.touch, masses[t], rubbed, slip, push);
      give(mobility, at, friction - rubbed, twists);
      at.given = push * normal + friction;
      most = std::max(most, at.given.norm());
      changed = std::max(changed, (at.given - before).norm());
    }
    if (changed <= kSettled * most) return;
  }
}

/// Whether a touch takes all that static friction gives.
bool slips(const BodyTouch& at) {
  const double push = at.touch.normal.dot(at.given);
  return (across(at.touch.normal) * at.given).norm() >= (1 - kSettled) * at.touch.stick * push;
}

}  // namespace

EffectiveMass effective_mass(std::span<const Mat6> mobilities, const BodyTouch& at) {
  Mat3 response = mobility(mobilities[at.body], at.arm, at.arm);  // 1/kg
  if (at.other != kNoBody) response += mobility(mobilities[at.other], at.other_arm, at.other_arm);
  const Vec3& normal = at.touch.normal;
  const Mat3 plane = across(normal), slip = plane * response * plane;
  const double along = normal.dot(response * normal);
  const Mat3 whole = slip + along * normal * normal.transpose();
  return {1 / along, plane * whole.inverse() * plane, 1 / slip.norm()};
}

void relax(std::span<const Mat6> mobility, std::span<const EffectiveMass> masses,
           std::span<BodyTouch> touches, std::span<Vec6> twists) {
  for (BodyTouch& at : touches) at.touch.state = Touch::State::sticks;
  sweep(mobility, masses, touches, twists);
  bool slide = false;
  for (BodyTouch& at : touches) {
    if (at.touch.slide == at.touch.stick || !slips(at)) continue;
    at.touch.state = Touch::State::slides;
    slide = true;
  }
  if (slide) sweep(mobility, masses, touches, twists);
}

namespace {

constexpr double kUnchanged = 1e-6;  // of the greatest twist: a change as good as none

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

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

}  // namespace

Pose BodyContacts::pose_of(const Mechanism& mechanism, std::uint32_t one,
                           const std::vector<double>& state) const {
  if (one >= bodies()) {
    return {ConstMap(&state[mechanism.position(beads_[one - bodies()])]), Quat::Identity()};
  }
  const double* q = &state[mechanism.pose(one)];
  return {ConstMap(q), quaternion(q + 3)};
}

Vec6 BodyContacts::twist_of(const Mechanism& mechanism, std::uint32_t one,
                            const std::vector<double>& state) const {
  if (one < bodies()) return Eigen::Map<const Vec6>(&state[mechanism.twist(one)]);
  Vec6 twist = Vec6::Zero();
  twist.head<3>() = ConstMap(&state[mechanism.velocity(beads_[one - bodies()])]);
  return twist;
}

void BodyContacts::set_twist(const Mechanism& mechanism, std::uint32_t one, const Vec6& twist,
                             std::vector<double>& state) const {
  if (one < bodies()) {
    Eigen::Map<Vec6>(state.data() + mechanism.twist(one)) = twist;
  } else {
    Map(state.data() + mechanism.velocity(beads_[one - bodies()])) = twist.head<3>();
  }
}

Mat6 BodyContacts::mobility_of(const Mechanism& mechanism, std::uint32_t one,
                               const std::vector<double>& state) const {
  if (one >= bodies()) {
    return mobility(mechanism.inverse_mass()[beads_[one - bodies()]], Mat3::Zero());
  }
  const auto& body = mechanism.bodies()[one];
  const Mat3 turn = pose_of(mechanism, one, state).rotation.toRotationMatrix();
  return mobility(body.inverse_mass, turn * body.inverse_inertia * turn.transpose());
}

/// How far a point of one has moved since `before` (m).
Vec3 BodyContacts::moved(const Mechanism& mechanism, std::uint32_t one, const Vec3& arm,
                         const std::vector<double>& before,
                         const std::vector<double>& state) const {
  const Pose now = pose_of(mechanism, one, state), old = pose_of(mechanism, one, before);
  return now.position + arm - old.to_world(now.rotation.conjugate() * arm);
}

void BodyContacts::rebuild(const Mechanism& mechanism, const World& world) {
  meetings_.clear();
  beads_.clear();
  groups_.clear();
  points_.clear();
  numbers_.clear();
  if (!has_touching_bodies(world) && world.bead_pairs.empty()) return;
  obstacles_ = world.obstacles;
  capsules_ = capsules_of_free_bodies(world);
  meetings_ = meetings_of_bodies(world, obstacles_, world.pairs);
  frames_.reserve(obstacles_.size());
  std::size_t spots = kSpots.size() * meetings_.size();
  const std::vector<BodyMeeting> of_beads = meetings_of_beads(world, mechanism, world.bead_pairs);
  spots += of_beads.size();
  add_beads(world, of_beads);
  touches_.reserve(spots);
  masses_.reserve(spots);
  here_.assign(capsules_.size(), kNoBody);
  numbers_.reserve(capsules_.size());
  mobility_.reserve(capsules_.size());
  twists_.reserve(capsules_.size());
}

/// Numbers beads behind the bodies.
void BodyContacts::add_beads(const World& world, std::span<const BodyMeeting> meetings) {
  std::vector<double> radius;
  for (const Connector& connector : world.connectors) {
    radius.insert(radius.end(), connector.particles(), connector.radius);
  }
  std::vector<std::uint32_t> number(radius.size(), kNoBody);
  for (const BodyMeeting& meeting : meetings) {
    std::uint32_t& one = number[meeting.body];
    if (one == kNoBody) {
      one = small(capsules_.size());
      capsules_.push_back({.radius = radius[meeting.body]});
      beads_.push_back(meeting.body);
    }
    if (groups_.empty() || meetings_[groups_.back().first].other != meeting.other) {
      groups_.push_back({.first = meetings_.size()});
    }
    const BodyCapsule& solid = capsules_[meeting.other];
    const double reach = (solid.to - solid.from).norm() / 2 + solid.radius + radius[meeting.body];
    groups_.back().reach = std::max(groups_.back().reach, reach);
    points_.push_back(meeting.body);
    meetings_.push_back(meeting);
    meetings_.back().body = one;
    groups_.back().end = meetings_.size();
  }
}

void BodyContacts::find(const Mechanism& mechanism, double time, double dt,
                        const std::vector<double>& state) {
  // In a pile all fall alike, and what moves the lowest out moves it into the next.
  const double near = dt * resting_speed(mechanism, dt);
  frames_.clear();
  for (const Obstacle& obstacle : obstacles_) frames_.push_back(obstacle.frame(time));
  touches_.clear();
  for (const std::uint32_t one : numbers_) here_[one] = kNoBody;
  numbers_.clear();
  const std::size_t of_bodies = meetings_.size() - points_.size();
  for (std::size_t m = 0; m < of_bodies; ++m) find_at(mechanism, m, near, state);
  for (const BeadGroup& group : groups_) {
    const Vec3 middle = solid_of(mechanism, meetings_[group.first], state).position;
    const double reach = group.reach + near;
    for (std::size_t m = group.first; m < group.end; ++m) {
      const ConstMap bead(&state[mechanism.position(points_[m - of_bodies])]);
      if ((bead - middle).squaredNorm() <= reach * reach) find_at(mechanism, m, near, state);
    }
  }
  find_masses(mechanism, state);
}

/// The frame of what a meeting is with.
Pose BodyContacts::solid_of(const Mechanism& mechanism, const BodyMeeting& meeting,
                            const std::vector<double>& state) const {
  if (meeting.other == kNoBody) return frames_[meeting.obstacle].pose();
  const Pose other = pose_of(mechanism, meeting.other, state);
  return pose_of_solid(meeting, other.position, other.rotation);
}

void BodyContacts::find_at(const Mechanism& mechanism, std::size_t index, double near,
                           const std::vector<double>& state) {
  const BodyMeeting& meeting = meetings_[index];
  const Capsule capsule = placed(capsules_[meeting.body], pose_of(mechanism, meeting.body, state));
  const Pose solid = solid_of(mechanism, meeting, state);
  if (is_far(meeting.shape, solid, capsule, near)) return;
  const auto gaps = all_gaps(meeting.shape, solid, capsule);
  const auto touches = [&](const SpotGap& gap) { return gap.distance <= near; };
  if (std::ranges::none_of(gaps, touches)) return;
  // What moves one spot out may move another in: all of them count.
  for (const Spot spot : kSpots) {
    const SpotGap& gap = gaps[static_cast<std::size_t>(spot)];
    if (gap.distinct) add(mechanism, index, capsule, spot, gap, state);
  }
}

std::uint32_t BodyContacts::number_here(std::uint32_t one) {
  if (here_[one] == kNoBody) {
    here_[one] = small(numbers_.size());
    numbers_.push_back(one);
  }
  return here_[one];
}

void BodyContacts::add(const Mechanism& mechanism, std::size_t index, const Capsule& capsule,
                       Spot spot, const SpotGap& gap, const std::vector<double>& state) {
  const BodyMeeting& meeting = meetings_[index];
  const Vec3 point = capsule.at(gap.along) - capsule.radius * gap.normal;
  const Vec3 origin = meeting.other == kNoBody ? frames_[meeting.obstacle].position
                                               : pose_of(mechanism, meeting.other, state).position;
  BodyTouch& at = touches_.emplace_back();
  at.body = number_here(meeting.body);
  if (meeting.other != kNoBody) at.other = number_here(meeting.other);
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
  for (const std::uint32_t one : numbers_) {
    mobility_.push_back(mobility_of(mechanism, one, state));
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
  twists_.assign(numbers_.size(), Vec6::Zero());
  relax(mobility_, masses_, touches_, twists_);
  for (std::size_t i = 0; i < twists_.size(); ++i) {
    if (twists_[i].isZero(0)) continue;
    const std::uint32_t one = numbers_[i];
    if (one >= bodies()) {
      Map(&state[mechanism.position(beads_[one - bodies()])]) += twists_[i].head<3>();
      continue;
    }
    double* q = &state[mechanism.pose(one)];
    Map(q) += twists_[i].head<3>();
    rotate(twists_[i].tail<3>(), q + 3);
  }
  for (const auto& carried : mechanism.body_points()) {
    const std::uint32_t here = here_[carried.body];
    if (here == kNoBody || twists_[here].isZero(0)) continue;
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
    at.touch.surface =
        dt * surface_velocity(at) - moved(mechanism, numbers_[at.body], at.arm, before, state);
    if (at.other == kNoBody) continue;
    at.touch.surface += moved(mechanism, numbers_[at.other], at.other_arm, before, state);
  }
  use_friction(true);
  shift(mechanism, state);
}

/// The velocities with which touches are to end, as they came with those of `came`. True where
/// some came faster than gravity makes them.
bool BodyContacts::find_rebounds(const Mechanism& mechanism, double dt,
                                 const std::vector<double>& came) {
  for (std::size_t i = 0; i < twists_.size(); ++i) {
    twists_[i] = twist_of(mechanism, numbers_[i], came);
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
  for (std::size_t i = 0; i < twists_.size(); ++i) {
    twists_[i] = twist_of(mechanism, numbers_[i], state);
  }
  relax(mobility_, masses_, touches_, twists_);
  double changed = 0, most = 0;
  for (std::size_t i = 0; i < twists_.size(); ++i) {
    const Vec6 now = twist_of(mechanism, numbers_[i], state);
    changed = std::max(changed, (twists_[i] - now).norm());
    most = std::max(most, twists_[i].norm());
    set_twist(mechanism, numbers_[i], twists_[i], state);
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
